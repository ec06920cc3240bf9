use crate::search::MOST_STEPS;

/// How to calibrate.
///
/// The default is the joint bundle with one dead path per lock, in the frame of the stations'
/// nominal positions, under noise that is estimated from the residual.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
pub struct Options {
    /// What is unknown.
    pub formulation: Formulation,
    /// What the axis is taken for.
    pub axis: AxisModel,
    /// What shares a dead path.
    pub dead_path: DeadPath,
    /// What ties the result to the machine.
    pub gauge: Gauge,
    /// Frame in which the errors are given.
    pub order: ErrorOrder,
    /// Standard uncertainties.
    pub noise: Noise,
    /// Steps of the search before it gives up, from each of its two starts.
    ///
    /// 100: a well-posed survey takes under 20.
    pub max_iterations: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            formulation: Formulation::default(),
            axis: AxisModel::default(),
            dead_path: DeadPath::default(),
            gauge: Gauge::default(),
            order: ErrorOrder::default(),
            noise: Noise::default(),
            max_iterations: MOST_STEPS,
        }
    }
}

/// What is unknown beside stations and dead paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Formulation {
    /// Reflectors and six errors per angle: the reflectors are one rigid body.
    #[default]
    Joint,
    /// Every target point, with the distances between reflectors as further, weighted rows; the
    /// errors follow from the points, angle by angle (\[B\], steps S2 to S4).
    FreePoints,
}

/// What the axis is taken for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum AxisModel {
    /// Six errors at every angle.
    #[default]
    Free,
    /// A perfect axis where the drawing has it; its location and its motion are then what the model
    /// may be missing.
    Fixed,
    /// A perfect axis whose location is fitted.
    Located,
}

/// What shares a dead path, the distance at which the tracer reads zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum DeadPath {
    /// Each station and mount have their own: the beam is aimed anew when the reflector moves.
    #[default]
    Lock,
    /// One per station.
    Station,
}

/// What ties the result to the machine, which distances alone cannot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Gauge {
    /// The stations' nominal positions, with [`Noise::station_mm`]; as `Inner` where that is
    /// absent.
    #[default]
    Stations,
    /// The first station in its nominal place, the second in the nominal direction from it, the
    /// third in the nominal plane.
    Minimal,
    /// The rigid fit of all stations to their nominal positions, taken as without error.
    Inner,
    /// The same, where how the stations lie to each other is data with [`Noise::station_mm`].
    Shape,
}

/// Frame in which the six errors are given.
///
/// `e_fixed = Rot(b)·e_rotating`, exactly, for displacement and rotation alike.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ErrorOrder {
    /// The machine frame, ISO 230-7.
    #[default]
    Fixed,
    /// The frame that turns with the axis.
    Rotating,
}

/// Standard uncertainties.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Noise {
    /// Of one displacement; `None`: estimated from the residual.
    pub displacement_mm: Option<f64>,
    /// Of a distance between two reflectors from run to run, the repeatability of the axis; it
    /// weighs the rigid-body rows of [`Formulation::FreePoints`]. `None`: that of a displacement.
    pub rigid_mm: Option<f64>,
    /// Of each coordinate of the stations' nominal positions. `None`: they serve only to orient
    /// the result.
    pub station_mm: Option<f64>,
}
