/// Why a geometric question has no usable answer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// A number is NaN or infinite, or so large that its square overflows.
    #[error("{argument} is not a finite number of usable size")]
    NonFinite {
        /// Which argument.
        argument: &'static str,
    },
    /// A direction or normal has no length.
    #[error("{argument} has no length, so it gives no direction")]
    NoDirection {
        /// Which argument.
        argument: &'static str,
    },
    /// A couple without force has no line of action.
    #[error("a wrench of force {force_n:e} N has no line of action")]
    NoForce {
        /// Magnitude of the force.
        force_n: f64,
    },
    /// A linear map flattens the plane and has no inverse.
    #[error(
        "planar map has no inverse: its scales are {major_scale:e} and {minor_scale:e}; \
         points on one line give no second scale"
    )]
    Singular {
        /// Larger singular value of the linear part.
        major_scale: f64,
        /// Smaller singular value of the linear part.
        minor_scale: f64,
    },
    /// A planar map is not a proper rotation with a translation.
    #[error(
        "planar map is not a rigid motion: scales {major_scale} and {minor_scale}, \
         determinant {determinant}"
    )]
    NotRigid {
        /// Larger singular value of the linear part.
        major_scale: f64,
        /// Smaller singular value of the linear part.
        minor_scale: f64,
        /// Negative for a reflection.
        determinant: f64,
    },
    /// A radius is zero, or negative where the sign has no meaning.
    #[error("radius {radius_mm} mm does not make a surface; a flat has an infinite radius")]
    InvalidRadius {
        /// Radius given.
        radius_mm: f64,
    },
    /// A polynomial has a term of too high a degree.
    #[error("a term of degree {degree} is beyond {limit}, the highest that can be evaluated")]
    DegreeTooHigh {
        /// Sum of the term's exponents.
        degree: usize,
        /// Highest degree accepted.
        limit: usize,
    },
    /// A grid of heights is too small, or its heights do not fill it.
    #[error(
        "a grid of {columns} × {rows} places with {heights} heights makes no surface; it needs 4 \
         places or more each way, and one height for each"
    )]
    InvalidGrid {
        /// Places along x.
        columns: usize,
        /// Places along y.
        rows: usize,
        /// Heights given.
        heights: usize,
    },
    /// A spline has a degree that cannot be evaluated.
    #[error("degree {degree} along {direction} must be from 1 to {limit}")]
    InvalidDegree {
        /// Direction on the surface, u or v.
        direction: &'static str,
        /// Degree given.
        degree: usize,
        /// Highest degree accepted.
        limit: usize,
    },
    /// A spline has fewer knots than one span needs.
    #[error("{got} knots along {direction}; this degree needs {needed} or more")]
    TooFewKnots {
        /// Direction on the surface, u or v.
        direction: &'static str,
        /// Knots given.
        got: usize,
        /// Fewest knots, 2 (degree + 1).
        needed: usize,
    },
    /// Knots do not increase.
    #[error("knot {} along {direction} is smaller than the one before it", index + 1)]
    KnotsDecrease {
        /// Direction on the surface, u or v.
        direction: &'static str,
        /// Position of the smaller knot.
        index: usize,
    },
    /// A knot is repeated so often that the surface falls apart there.
    #[error(
        "the knots along {direction} repeat knot {} more than {degree} times; at degree {degree} \
         that tears the surface",
        index + 1
    )]
    KnotRepeated {
        /// Direction on the surface, u or v.
        direction: &'static str,
        /// Position of the first of the equal knots.
        index: usize,
        /// Degree along that direction.
        degree: usize,
    },
    /// Control points or weights do not fill the net that the knots make.
    #[error(
        "the knots make a net of {columns} × {rows} control points; got {points} points and \
         {weights} weights"
    )]
    InvalidNet {
        /// Control points along u.
        columns: usize,
        /// Control points along v.
        rows: usize,
        /// Points given.
        points: usize,
        /// Weights given.
        weights: usize,
    },
    /// A control point has a weight that is not positive.
    #[error("weight {weight} of control point {} is not positive", index + 1)]
    InvalidWeight {
        /// Position in the input.
        index: usize,
        /// Weight given.
        weight: f64,
    },
    /// The surface has no tangent plane: its control points coincide there, or lie on a line.
    #[error("the surface has no normal at u = {u}, v = {v}: its control points collapse there")]
    NoNormal {
        /// Place along u.
        u: f64,
        /// Place along v.
        v: f64,
    },
    /// A place is not on the surface.
    #[error("u = {u}, v = {v} is beside the surface's knots")]
    OutsideKnots {
        /// Place along u.
        u: f64,
        /// Place along v.
        v: f64,
    },
    /// An aperture is not positive.
    #[error("aperture diameter {diameter_mm} mm is not positive")]
    InvalidAperture {
        /// Diameter given.
        diameter_mm: f64,
    },
    /// The aperture reaches to where the conic ends or stands upright.
    #[error(
        "aperture reaches {rim_mm} mm from the axis, but the conic ends at {limit_mm} mm; \
         reduce the diameter or check radius and conic constant"
    )]
    ApertureBeyondConic {
        /// Largest distance of the rim from the axis.
        rim_mm: f64,
        /// Distance from the axis at which the slope is infinite.
        limit_mm: f64,
    },
    /// The surface has no height there: the conic has ended.
    #[error("sag is not defined {radius_mm} mm from the axis, the conic ends at {limit_mm} mm")]
    SagUndefined {
        /// Distance from the axis.
        radius_mm: f64,
        /// Distance from the axis at which the slope is infinite.
        limit_mm: f64,
    },
    /// The answer lies off the part.
    #[error(
        "answer lies {distance_mm} mm from the centre of the aperture, whose radius is \
         {aperture_radius_mm} mm"
    )]
    OutsideAperture {
        /// Lateral distance of the answer from the aperture's centre; for a closest point that lies
        /// past the margin, of the margin.
        distance_mm: f64,
        /// Radius of the aperture.
        aperture_radius_mm: f64,
    },
    /// Several points are as close, or so nearly that round-off would decide.
    #[error(
        "closest point is ambiguous: at {distance_mm} mm the query is on or near a centre of \
         curvature or halfway between two parts of the surface; query closer to the surface"
    )]
    AmbiguousFoot {
        /// Distance to the closest points.
        distance_mm: f64,
    },
    /// The line passes the surface by.
    #[error("line does not meet the surface")]
    Misses,
    /// The surface is met, but behind the start of the ray.
    #[error("ray meets the surface only {distance_mm} mm behind its start; reverse its direction")]
    BehindRay {
        /// Distance from the start to the nearest hit behind it, positive.
        distance_mm: f64,
    },
    /// The line lies in the surface, or is tangent over a length.
    #[error("line lies in the surface over a length, so it has no single hit")]
    LineInSurface,
}

/// Fails unless every value is finite.
pub(crate) fn finite<'a>(
    values: impl IntoIterator<Item = &'a f64>,
    argument: &'static str,
) -> Result<(), GeometryError> {
    if values.into_iter().all(|v| v.is_finite()) {
        Ok(())
    } else {
        Err(GeometryError::NonFinite { argument })
    }
}
