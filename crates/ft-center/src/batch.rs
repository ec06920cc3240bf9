//! Many samples at once, read once.

use geometry::Wrench;
use nalgebra::{Matrix2, Point2, Vector2, Vector3};

use crate::FtCenterError;
use crate::error::require_positive;

/// Batches whose means tell the noise of the centre.
const BATCHES: usize = 64;

/// Samples summed side by side: one register of each sum, so that all of them stay in registers.
const LANES: usize = 4;

/// Share of the load in samples of the other sign beyond which the record is no press.
const MAX_OTHER_SIGN_RATIO: f64 = 0.05;

/// Wrenches on the sensor, one array per component, all of one length.
#[derive(Clone, Copy, Debug)]
pub struct WrenchArrays<'a> {
    /// Force along x.
    pub fx_n: &'a [f64],
    /// Force along y.
    pub fy_n: &'a [f64],
    /// Force along z.
    pub fz_n: &'a [f64],
    /// Moment about x.
    pub mx_nmm: &'a [f64],
    /// Moment about y.
    pub my_nmm: &'a [f64],
    /// Moment about z.
    pub mz_nmm: &'a [f64],
}

/// Centre of pressure of many samples.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BatchCenter {
    /// Least-squares centre, weights `Fz²`; the mean over whole turns of a spinning head.
    pub center_mm: Point2<f64>,
    /// Covariance of `center_mm` from the scatter of batch means: right where a batch, 1/64 of
    /// the samples, is longer than the noise remembers and than the spin turns.
    pub covariance_mm2: Matrix2<f64>,
    /// Batches with contact, less one.
    pub degrees_of_freedom: usize,
    /// `Fz`-weighted mean wrench of the samples in contact.
    pub mean_wrench: Wrench,
    /// Mean moment about z that the force does not explain, weighted in the same way.
    pub free_moment_nmm: f64,
    /// Samples in contact.
    pub contact_samples: usize,
}

/// Sums over the samples of a batch that are in contact.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    /// `|Fz|`, `Fz`, `Fz²`.
    load: f64,
    fz: f64,
    square: f64,
    /// `Fz Fx`, `Fz Fy`.
    fx: f64,
    fy: f64,
    /// `Fz (z0 Fx − My)`, `Fz (Mx + z0 Fy)`.
    qx: f64,
    qy: f64,
    /// `Fz` times the free moment.
    free: f64,
}

/// Centre of pressure of all samples with `|Fz|` of at least `min_fz_n`, in one pass.
///
/// # Errors
///
/// [`FtCenterError::UnequalLengths`], [`FtCenterError::NotPositive`],
/// [`FtCenterError::InvalidHeight`], [`FtCenterError::NotFinite`],
/// [`FtCenterError::TooFewContactSamples`] when fewer than two batches are in contact,
/// [`FtCenterError::MixedSign`].
pub fn solve_batch(
    arrays: &WrenchArrays<'_>,
    z0_mm: f64,
    min_fz_n: f64,
) -> Result<BatchCenter, FtCenterError> {
    arrays.check(z0_mm, min_fz_n)?;
    let n = arrays.fz_n.len();
    let size = n.div_ceil(BATCHES).max(1);
    let batches: Vec<_> = (0..n)
        .step_by(size)
        .map(|start| arrays.slice(start, (start + size).min(n)).sums(z0_mm, min_fz_n))
        .collect();
    let total = batches.iter().fold(Sums::default(), Sums::plus);
    if !total.is_finite() {
        return Err(arrays.not_finite());
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count, exact below 2^53"
    )]
    let contact_samples = total.count as usize;
    let used = batches.iter().filter(|b| b.count > 0.0).count();
    if used < 2 {
        let (contact, given) = (contact_samples, n);
        return Err(FtCenterError::TooFewContactSamples { contact, given, needed: 2, min_fz_n });
    }
    if total.load - total.fz.abs() > 2.0 * MAX_OTHER_SIGN_RATIO * total.load {
        return Err(arrays.mixed_sign(min_fz_n));
    }
    let center = Vector2::new(total.qx, total.qy) / total.square;
    let scatter = batches.iter().fold(Matrix2::zeros(), |sum, b| {
        let d = Vector2::new(b.qx, b.qy) - center * b.square;
        sum + d * d.transpose()
    });
    let degrees_of_freedom = used - 1;
    let correction = crate::count(used) / crate::count(degrees_of_freedom);
    let force_n = Vector3::new(total.fx, total.fy, total.square) / total.fz;
    let free_moment_nmm = total.free / total.fz;
    let arm = Vector3::new(center.x, center.y, z0_mm);
    let torque_nmm = arm.cross(&force_n) + Vector3::z() * free_moment_nmm;
    Ok(BatchCenter {
        center_mm: Point2::from(center),
        covariance_mm2: scatter * (correction / total.square.powi(2)),
        degrees_of_freedom,
        mean_wrench: Wrench { force_n, torque_nmm },
        free_moment_nmm,
        contact_samples,
    })
}

/// Centre of pressure of every sample, (1.11) of \[A\]; NaN where there is no contact.
///
/// # Errors
///
/// [`FtCenterError::UnequalLengths`] also for the outputs, [`FtCenterError::NotPositive`],
/// [`FtCenterError::InvalidHeight`].
pub fn centers_into(
    arrays: &WrenchArrays<'_>,
    z0_mm: f64,
    min_fz_n: f64,
    x_mm: &mut [f64],
    y_mm: &mut [f64],
) -> Result<(), FtCenterError> {
    arrays.check(z0_mm, min_fz_n)?;
    let n = arrays.fz_n.len();
    if x_mm.len() != n || y_mm.len() != n {
        return Err(FtCenterError::UnequalLengths { lengths: vec![n, x_mm.len(), y_mm.len()] });
    }
    let forces = arrays.fx_n.iter().zip(arrays.fy_n).zip(arrays.fz_n);
    let moments = arrays.mx_nmm.iter().zip(arrays.my_nmm);
    let out = x_mm.iter_mut().zip(y_mm);
    for ((((fx, fy), fz), (mx, my)), (x, y)) in forces.zip(moments).zip(out) {
        let inverse = if fz.abs() >= min_fz_n { 1.0 / fz } else { f64::NAN };
        *x = (z0_mm * fx - my) * inverse;
        *y = (mx + z0_mm * fy) * inverse;
    }
    Ok(())
}

impl<'a> WrenchArrays<'a> {
    fn all(&self) -> [&'a [f64]; 6] {
        [self.fx_n, self.fy_n, self.fz_n, self.mx_nmm, self.my_nmm, self.mz_nmm]
    }

    fn check(&self, z0_mm: f64, min_fz_n: f64) -> Result<(), FtCenterError> {
        require_positive(min_fz_n, "min_fz_n")?;
        if !z0_mm.is_finite() {
            return Err(FtCenterError::InvalidHeight { z0_mm });
        }
        let lengths = self.all().map(<[f64]>::len);
        if lengths.iter().any(|&l| l != lengths[0]) {
            return Err(FtCenterError::UnequalLengths { lengths: lengths.to_vec() });
        }
        Ok(())
    }

    fn slice(&self, start: usize, end: usize) -> Self {
        let [fx_n, fy_n, fz_n, mx_nmm, my_nmm, mz_nmm] = self.all().map(|a| &a[start..end]);
        Self { fx_n, fy_n, fz_n, mx_nmm, my_nmm, mz_nmm }
    }

    fn sums(&self, z0_mm: f64, min_fz_n: f64) -> Sums {
        pulp::Arch::new().dispatch(Summing { arrays: *self, z0_mm, min_fz_n })
    }

    fn not_finite(&self) -> FtCenterError {
        let n = self.fz_n.len();
        let bad = |i: &usize| self.all().iter().any(|a| !a[*i].is_finite());
        (0..n)
            .find(bad)
            .map_or(FtCenterError::OutOfRange, |index| FtCenterError::NotFinite { index })
    }

    fn mixed_sign(&self, min_fz_n: f64) -> FtCenterError {
        let positive = self.fz_n.iter().filter(|f| **f >= min_fz_n).count();
        let negative = self.fz_n.iter().filter(|f| **f <= -min_fz_n).count();
        FtCenterError::MixedSign { positive, negative, min_fz_n }
    }
}

/// Sums in the widest registers that the machine has.
struct Summing<'a> {
    arrays: WrenchArrays<'a>,
    z0_mm: f64,
    min_fz_n: f64,
}

impl pulp::WithSimd for Summing<'_> {
    type Output = Sums;

    #[expect(clippy::inline_always, reason = "inlined into what is compiled for wide registers")]
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) -> Sums {
        let Self { arrays, z0_mm, min_fz_n } = self;
        let [fx, fy, fz, mx, my, mz] = arrays.all().map(|a| a.as_chunks::<LANES>());
        let mut lanes = LaneSums::default();
        let columns = fx.0.iter().zip(fy.0).zip(fz.0).zip(mx.0.iter().zip(my.0).zip(mz.0));
        for (((fx, fy), fz), ((mx, my), mz)) in columns {
            lanes.add(z0_mm, min_fz_n, [fx, fy, fz, mx, my, mz]);
        }
        let mut sums = lanes.total();
        for i in 0..fz.1.len() {
            let rest = [fx.1[i], fy.1[i], fz.1[i], mx.1[i], my.1[i], mz.1[i]];
            sums.add(z0_mm, min_fz_n, rest);
        }
        sums
    }
}

/// [`Sums`], one for each lane.
#[derive(Default)]
struct LaneSums {
    terms: [[f64; LANES]; 9],
}

impl LaneSums {
    #[expect(clippy::inline_always, reason = "inlined into what is compiled for wide registers")]
    #[inline(always)]
    fn add(&mut self, z0_mm: f64, min_fz_n: f64, [fx, fy, fz, mx, my, mz]: [&[f64; LANES]; 6]) {
        let mut new = [[0.0; LANES]; 9];
        for l in 0..LANES {
            let touching = fz[l].abs() >= min_fz_n;
            // A product with zero keeps NaN, so that it is seen.
            let one = if touching { 1.0 } else { 0.0 };
            let w = fz[l] * one;
            let (qx, qy) = (z0_mm * fx[l] - my[l], mx[l] + z0_mm * fy[l]);
            // Fz (Mz − (x Fy − y Fx)) with x = qx/Fz, y = qy/Fz.
            let free = fz[l] * mz[l] - qx * fy[l] + qy * fx[l];
            new[0][l] = one;
            new[1][l] = w.abs();
            new[2][l] = w;
            new[3][l] = w * w;
            new[4][l] = w * fx[l];
            new[5][l] = w * fy[l];
            new[6][l] = w * qx;
            new[7][l] = w * qy;
            new[8][l] = free * one;
        }
        for (terms, new) in self.terms.iter_mut().zip(&new) {
            for (term, new) in terms.iter_mut().zip(new) {
                *term += new;
            }
        }
    }

    fn total(&self) -> Sums {
        let [count, load, fz, square, fx, fy, qx, qy, free] =
            self.terms.map(|lanes| lanes.iter().sum::<f64>());
        Sums { count, load, fz, square, fx, fy, qx, qy, free }
    }
}

impl Sums {
    fn add(&mut self, z0_mm: f64, min_fz_n: f64, [fx, fy, fz, mx, my, mz]: [f64; 6]) {
        let touching = fz.abs() >= min_fz_n;
        // A product with zero keeps NaN, so that it is seen.
        let w = if touching { fz } else { fz * 0.0 };
        let (qx, qy) = (z0_mm * fx - my, mx + z0_mm * fy);
        self.count += if touching { 1.0 } else { 0.0 };
        self.load += w.abs();
        self.fz += w;
        self.square += w * w;
        self.fx += w * fx;
        self.fy += w * fy;
        self.qx += w * qx;
        self.qy += w * qy;
        // Fz (Mz − (x Fy − y Fx)) with x = qx/Fz, y = qy/Fz.
        let free = fz * mz - qx * fy + qy * fx;
        self.free += if touching { free } else { free * 0.0 };
    }

    fn plus(self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            load: self.load + other.load,
            fz: self.fz + other.fz,
            square: self.square + other.square,
            fx: self.fx + other.fx,
            fy: self.fy + other.fy,
            qx: self.qx + other.qx,
            qy: self.qy + other.qy,
            free: self.free + other.free,
        }
    }

    fn is_finite(&self) -> bool {
        (self.load + self.square + self.fx + self.fy + self.qx + self.qy + self.free).is_finite()
    }
}
