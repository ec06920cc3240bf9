//! A plant for force loops: pneumatic cylinders with lag, dead time and seal friction, a contact
//! that hardens, a freeform path, noisy sensors. Written from the physics, apart from the crate;
//! one axis, along the normal.

use std::f64::consts::TAU;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Fine steps per sample.
const FINE: usize = 20;

/// What stands between a command and the force it leads to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plant {
    pub(crate) interval_s: f64,
    /// From a sample to the moment when its command begins to act.
    pub(crate) delay_s: f64,
    /// Time constant of the cylinder's position loop.
    pub(crate) lag_s: f64,
    /// Dead zone that the seals make: the piston moves only beyond it.
    pub(crate) seal_mm: f64,
    /// Stiffness of the contact where it begins.
    pub(crate) contact_n_per_mm: f64,
    /// Share by which it is stiffer per 100 N.
    pub(crate) hardens: f64,
    /// Standard deviation of the force read.
    pub(crate) noise_n: f64,
    /// Amplitude of the surface's error, at three wavelengths.
    pub(crate) path_mm: f64,
}

/// What a run of the loop gave.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outcome {
    /// Root mean square of force − reference after the first fifth.
    pub(crate) rms_n: f64,
    /// Largest excursion of the force in the last quarter over that in the second.
    pub(crate) growth: f64,
}

impl Plant {
    /// Height of the surface over the programmed path, mm: it rises and falls within seconds.
    fn surface(&self, t: f64) -> f64 {
        let waves = (TAU * 0.25 * t).sin() + 0.4 * (TAU * 0.9 * t + 1.0).sin();
        self.path_mm * (waves + 0.15 * (TAU * 2.3 * t + 2.0).sin())
    }

    /// Force for a depth: a spring that hardens.
    fn force(&self, depth_mm: f64) -> f64 {
        if depth_mm <= 0.0 {
            return 0.0;
        }
        let soft_n = self.contact_n_per_mm * depth_mm;
        soft_n * (1.0 + self.hardens * soft_n / 100.0)
    }

    /// Depth at which the force is as asked for.
    fn depth(&self, force_n: f64) -> f64 {
        let (mut low, mut high) = (0.0, force_n / self.contact_n_per_mm);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if self.force(middle) < force_n { low = middle } else { high = middle }
        }
        high
    }

    /// Runs `controller` (force read → offset commanded) for `n` samples from a contact in balance;
    /// `kick_mm` moves the surface once, to see whether the loop calms down.
    pub(crate) fn run(
        &self,
        reference_n: f64,
        n: usize,
        kick_mm: f64,
        mut controller: impl FnMut(f64) -> f64,
    ) -> Outcome {
        let mut rng = ChaCha8Rng::seed_from_u64(77);
        let start_mm = self.surface(0.0) - self.depth(reference_n);
        let (mut piston_mm, mut drive_mm) = (0.0_f64, 0.0_f64);
        let mut sent_mm: Vec<f64> = Vec::with_capacity(n);
        let (mut square, mut counted) = (0.0, 0);
        let mut swings = [0.0_f64; 4];
        for k in 0..n {
            let t = k as f64 * self.interval_s;
            let kick_mm = if k > n / 10 { kick_mm } else { 0.0 };
            let true_n = self.force(self.surface(t) + kick_mm - start_mm - piston_mm);
            let noise: f64 = StandardNormal.sample(&mut rng);
            sent_mm.push(controller(true_n + self.noise_n * noise));
            let quarter = 4 * k / n;
            swings[quarter] = swings[quarter].max((true_n - reference_n).abs());
            if k > n / 5 {
                square += (true_n - reference_n).powi(2);
                counted += 1;
            }
            let fine_s = self.interval_s / FINE as f64;
            for i in 0..FINE {
                let acts_s = t + (i as f64 + 0.5) * fine_s - self.delay_s;
                let input_mm =
                    if acts_s < 0.0 { 0.0 } else { sent_mm[(acts_s / self.interval_s) as usize] };
                let share = if self.lag_s > 0.0 { 1.0 - (-fine_s / self.lag_s).exp() } else { 1.0 };
                drive_mm += share * (input_mm - drive_mm);
                // Seals: the piston is dragged only once the drive has left it behind.
                piston_mm = piston_mm.clamp(drive_mm - self.seal_mm, drive_mm + self.seal_mm);
            }
        }
        let rms_n = (square / f64::from(counted)).sqrt();
        Outcome { rms_n, growth: swings[3] / swings[1] }
    }
}
