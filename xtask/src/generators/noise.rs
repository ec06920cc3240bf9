//! Stationary noise, white, coloured or heavy-tailed.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StudentT};

/// How successive values depend on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Colour {
    /// Independent values.
    White,
    /// First-order autoregression: the correlation of neighbours.
    Ar1(f64),
    /// 1/f over three decades: autoregressions with time constants 1, 4, 16, 64 and 256 samples,
    /// of equal variance.
    Pink,
    /// Independent values of Student's t with three degrees of freedom: single readings far off.
    HeavyTails,
}

/// Correlation of neighbours in each part of [`Colour::Pink`]: exp(−1/τ).
const PINK_CORRELATIONS: [f64; 5] =
    [0.367_879_4, 0.778_800_8, 0.939_413_1, 0.984_496_4, 0.996_101_4];

/// A source of noise of unit standard deviation from its first value on.
#[derive(Clone, Debug)]
pub(crate) struct Noise {
    heavy_tails: bool,
    correlations: Vec<f64>,
    states: Vec<f64>,
}

impl Noise {
    /// Starts in the stationary distribution, so that early values are as noisy as late ones.
    pub(crate) fn new(colour: Colour, rng: &mut ChaCha8Rng) -> Self {
        let correlations = match colour {
            Colour::White | Colour::HeavyTails => vec![0.0],
            Colour::Ar1(correlation) => vec![correlation],
            Colour::Pink => PINK_CORRELATIONS.to_vec(),
        };
        let states = correlations.iter().map(|_| gaussian(rng)).collect();
        Self { heavy_tails: colour == Colour::HeavyTails, correlations, states }
    }

    /// The next value.
    pub(crate) fn next(&mut self, rng: &mut ChaCha8Rng) -> f64 {
        if self.heavy_tails {
            return student(rng);
        }
        for (state, &correlation) in self.states.iter_mut().zip(&self.correlations) {
            *state =
                correlation * *state + (1.0 - correlation * correlation).sqrt() * gaussian(rng);
        }
        #[expect(clippy::cast_precision_loss, reason = "five parts at most")]
        let n_parts = self.states.len() as f64;
        self.states.iter().sum::<f64>() / n_parts.sqrt()
    }
}

/// One value of Student's t with three degrees of freedom over its standard deviation, √3.
fn student(rng: &mut ChaCha8Rng) -> f64 {
    let law = StudentT::new(3.0).expect("three is positive");
    let value: f64 = law.sample(rng);
    value / 3.0_f64.sqrt()
}

/// One standard normal value.
pub(crate) fn gaussian(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    /// Beyond the 97.5 % quantile of t₃ to either side lies one value in twenty: 200 ± 14 of 4000.
    #[test]
    fn heavy_tails_are_those_of_three_degrees_of_freedom() {
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let mut noise = Noise::new(Colour::HeavyTails, &mut rng);
        let far = |value: f64| value.abs() > 3.182_446 / 3.0_f64.sqrt();
        let beyond = (0..4000).filter(|_| far(noise.next(&mut rng))).count();
        assert!((150..250).contains(&beyond), "{beyond}");
    }

    /// Of 4000 values of correlation ρ the lag-one coefficient is known to about 1/√4000 = 0.016,
    /// and the variance of the least independent source here (pink) to about 0.25.
    #[test]
    fn noise_has_the_colour_and_the_size_it_says() {
        for (colour, correlation, variance_tolerance) in
            [(Colour::White, 0.0, 0.1), (Colour::Ar1(0.7), 0.7, 0.2), (Colour::Pink, 0.81, 0.5)]
        {
            let mut rng = ChaCha8Rng::seed_from_u64(5);
            let mut noise = Noise::new(colour, &mut rng);
            let values: Vec<f64> = (0..4000).map(|_| noise.next(&mut rng)).collect();
            let variance = values.iter().map(|v| v * v).sum::<f64>() / 4000.0;
            let lagged = values.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / 4000.0 / variance;
            assert!((variance - 1.0).abs() < variance_tolerance, "{colour:?}: {variance}");
            assert!((lagged - correlation).abs() < 0.06, "{colour:?}: {lagged}");
        }
    }
}
