//! A rotating head pressed on a six-axis force sensor: millimetres, newtons, N·mm, seconds.
//!
//! Everything is built in the machine's frame (z upwards, the head presses along −z) and turned
//! into the sensor's frame at the end, where the sensor adds what is wrong with it.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::generators::noise::{Colour, Noise};
use crate::generators::vector::{add, cross, rotate};

/// What is wrong with the sensor, its fixture or the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    /// Nothing.
    None,
    /// Constant bias of the wrench, `[fx, fy, fz, mx, my, mz]`.
    Bias([f64; 6]),
    /// Bias that grows in proportion to time: total over the session.
    BiasDrift([f64; 6]),
    /// Bias that grows and comes to rest, its time constant a quarter of the session: in the end.
    BiasSettles([f64; 6]),
    /// Moments read too large, relative.
    MomentGain(f64),
    /// Normal force read too large, relative.
    ForceGain(f64),
    /// Part of one true channel leaks into another: `(reads, leaks, factor)`, channel numbers
    /// of the wrench; a factor from force to moment is in mm.
    Crosstalk(usize, usize, f64),
    /// The platform is thicker than declared, mm.
    ContactHeight(f64),
    /// The platform leans: rise along the sensor's x and y, rad.
    PlatformTilt([f64; 2]),
    /// The head gives way sideways under load, machine frame, mm/N.
    LoadShift([f64; 2]),
    /// The machine's scales are too long, relative.
    FrameScale(f64),
    /// Mechanical play in the sensor's moment bridges, N·mm half width.
    Hysteresis(f64),
    /// The spindle housing warms and moves the head, machine frame, mm in the end; first-order
    /// warming with a time constant of a third of the session.
    SpindleGrowth([f64; 2]),
    /// The moment bridges are warm in the presses at the highest load: bias of mx and my there,
    /// N·mm.
    WarmLoad([f64; 2]),
    /// The pad slips along the drag, where that is more than a tenth of the load: mm.
    Slip(f64),
    /// The head gives way along the drag, mm/N.
    Compliance(f64),
    /// The normal force reads `fz·(1 + factor·|fz|)`, 1/N.
    ForceCurvature(f64),
}

/// What a press is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Its position is known and places the sensor in the machine.
    Frame,
    /// Its position is known and judges the answer.
    Check,
    /// Its position is the answer.
    Locate,
}

/// A session at the machine to simulate.
#[derive(Clone, Debug)]
pub(crate) struct Session {
    /// Presses that place the sensor.
    pub n_frame: usize,
    /// Presses that judge.
    pub n_check: usize,
    /// Presses of the head that is to be located.
    pub n_locate: usize,
    /// Loads taken in turn, N.
    pub loads_n: Vec<f64>,
    /// Sideways drag over the load while the head feeds; its direction changes from press to
    /// press.
    pub drag: f64,
    /// Whether the drag differs from press to press, from nothing to twice as much.
    pub drag_varies: bool,
    /// Samples per press.
    pub n_samples: usize,
    /// Samples per second.
    pub rate_hz: f64,
    /// Standard deviation of force channels, N.
    pub force_noise_n: f64,
    /// Standard deviation of moment channels, N·mm.
    pub moment_noise_nmm: f64,
    /// Dependence of successive samples of the sensor.
    pub colour: Colour,
    /// Law of the head's seat.
    pub seat: Colour,
    /// Standard deviation of the head's seat from press to press, each axis, mm.
    pub seat_mm: f64,
    /// Radius of the orbit of the pressure centre, mm.
    pub wobble_mm: f64,
    /// Offset of the head that is to be located, machine frame, mm.
    pub head_offset_mm: [f64; 2],
    /// Whether the sensor's z axis opposes the machine's.
    pub upside_down: bool,
    /// Whether the case declares the noise of a sample.
    pub declare_noise: bool,
    /// What is wrong.
    pub fault: Fault,
    /// What else is wrong.
    pub also: Fault,
    /// Seed of everything random.
    pub seed: u64,
}

impl Session {
    /// Eighteen presses and six check presses at 20 N and 60 N, nothing wrong.
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            n_frame: 18,
            n_check: 6,
            n_locate: 0,
            loads_n: vec![20.0, 60.0],
            drag: 0.08,
            drag_varies: false,
            n_samples: 64,
            rate_hz: 50.0,
            force_noise_n: 0.02,
            moment_noise_nmm: 1.0,
            colour: Colour::White,
            seat: Colour::White,
            seat_mm: 0.008,
            wobble_mm: 0.6,
            head_offset_mm: [0.0; 2],
            upside_down: false,
            declare_noise: false,
            fault: Fault::None,
            also: Fault::None,
            seed,
        }
    }

    fn faults(&self) -> [Fault; 2] {
        [self.fault, self.also]
    }
}

/// One simulated press.
#[derive(Clone, Debug)]
pub(crate) struct Press {
    /// What it is for.
    pub role: Role,
    /// Where the machine says the head is, mm.
    pub commanded_mm: [f64; 2],
    /// Turns per second.
    pub spin_hz: f64,
    /// Time since the session began, s, and the wrench read.
    pub samples: Vec<(f64, [f64; 6])>,
}

/// A simulated session.
#[derive(Clone, Debug)]
pub(crate) struct Recorded {
    /// In the order made.
    pub presses: Vec<Press>,
    /// Where the sensor's reference point is in the machine, mm.
    pub sensor_mm: [f64; 2],
    /// Direction of the sensor's x axis in the machine, rad.
    pub sensor_rad: f64,
    /// Height of the contact plane that the case declares, sensor frame, mm.
    pub declared_height_mm: f64,
}

impl Recorded {
    /// A position of the machine in the sensor's frame, mm.
    pub(crate) fn in_sensor(&self, machine_mm: [f64; 2]) -> [f64; 2] {
        let offset = [machine_mm[0] - self.sensor_mm[0], machine_mm[1] - self.sensor_mm[1], 0.0];
        let turned = rotate([0.0, 0.0, 1.0], -self.sensor_rad, offset);
        [turned[0], self.declared_height_mm.signum() * turned[1]]
    }
}

/// Thickness of the platform above the sensor's reference point, mm.
const PLATFORM_MM: f64 = 35.0;
/// Radius of the pad, mm.
const PAD_RADIUS_MM: f64 = 15.0;
/// Friction of the pad on the platform.
const FRICTION: f64 = 0.15;
/// Seconds from one press to the next.
const PRESS_INTERVAL_S: f64 = 90.0;
/// Samples before the head touches, which the force gate must reject.
const N_APPROACH: usize = 3;
/// The presses lie within a square of this half width around the sensor, mm.
pub(crate) const REACH_MM: f64 = 30.0;
/// Drag over load up to which the pad sticks.
const STICKS: f64 = 0.1;
/// Load at which the lateral compliance is counted from, N.
pub(crate) const REFERENCE_LOAD_N: f64 = 40.0;

/// Simulates a session.
pub(crate) fn simulate(session: &Session) -> Recorded {
    let mut rng = ChaCha8Rng::seed_from_u64(session.seed);
    let n_presses = session.n_frame + session.n_check + session.n_locate;
    let sensor_rad = rng.random_range(-0.6..0.6);
    let sensor_mm = [
        (rng.random_range(200.0..400.0_f64) * 1e3).round() / 1e3,
        (rng.random_range(-150.0..150.0_f64) * 1e3).round() / 1e3,
    ];
    let sign = if session.upside_down { -1.0 } else { 1.0 };
    let rig = Rig { session, sensor_rad, sensor_mm, sign };
    let plan = plan(session, sensor_mm, &mut rng);
    let mut play = [Play::default(); 2];
    let presses = (0..n_presses)
        .map(|index| rig.press(index, n_presses, &plan[index], &mut play, &mut rng))
        .collect();
    Recorded { presses, sensor_mm, sensor_rad, declared_height_mm: sign * PLATFORM_MM }
}

/// What the operator asks for.
struct Planned {
    role: Role,
    commanded_mm: [f64; 2],
    load_n: f64,
    drag: f64,
    drag_rad: f64,
}

/// Positions on a jittered grid in random order; loads in turn; drag directions a golden angle
/// apart, so that none goes with a position or a load.
fn plan(session: &Session, sensor_mm: [f64; 2], rng: &mut ChaCha8Rng) -> Vec<Planned> {
    const GOLDEN_RAD: f64 = 2.399_963_229_728_653;
    let n_known = session.n_frame + session.n_check;
    let n_presses = n_known + session.n_locate;
    let side = (1..=n_known).find(|s| s * s >= n_known).unwrap_or(1);
    let mut cells: Vec<usize> = (0..side * side).collect();
    for last in (1..cells.len()).rev() {
        cells.swap(last, rng.random_range(0..=last));
    }
    (0..n_presses)
        .map(|index| {
            let role = role_of(index, session);
            let pitch = 2.0 * REACH_MM / as_f64(side);
            let mut place = |cell: usize| {
                let middle = (as_f64(cell) + 0.5) * pitch - REACH_MM;
                ((middle + rng.random_range(-0.3..0.3) * pitch) * 1e3).round() / 1e3
            };
            let (x, y) = match role {
                Role::Locate => (0.0, 0.0),
                _ => (place(cells[index] % side), place(cells[index] / side)),
            };
            Planned {
                role,
                commanded_mm: [sensor_mm[0] + x, sensor_mm[1] + y],
                load_n: session.loads_n[rng.random_range(0..session.loads_n.len())],
                drag: if session.drag_varies {
                    session.drag * rng.random_range(0.0..2.0)
                } else {
                    session.drag
                },
                drag_rad: GOLDEN_RAD * as_f64(index),
            }
        })
        .collect()
}

/// Check presses spread evenly among the known ones; those to locate come last.
fn role_of(index: usize, session: &Session) -> Role {
    let n_known = session.n_frame + session.n_check;
    if index >= n_known {
        return Role::Locate;
    }
    let checks_before = |i: usize| i * session.n_check / n_known;
    if checks_before(index + 1) > checks_before(index) { Role::Check } else { Role::Frame }
}

/// The sensor on the machine.
struct Rig<'a> {
    session: &'a Session,
    sensor_rad: f64,
    sensor_mm: [f64; 2],
    sign: f64,
}

impl Rig<'_> {
    fn press(
        &self,
        index: usize,
        n_presses: usize,
        planned: &Planned,
        play: &mut [Play; 2],
        rng: &mut ChaCha8Rng,
    ) -> Press {
        let session = self.session;
        let start_s = PRESS_INTERVAL_S * as_f64(index);
        let session_s = PRESS_INTERVAL_S * as_f64(n_presses);
        let spin_hz = rng.random_range(1.8..2.6);
        let center_mm = self.center(planned, start_s / session_s, rng);
        let head = Head::new(session, spin_hz, planned, rng);
        // A minute and a half lies between presses: no colour of the sensor reaches that far.
        let mut channels: Vec<Noise> = (0..6).map(|_| Noise::new(session.colour, rng)).collect();
        let mut jitter: Vec<Noise> = (0..3).map(|_| Noise::new(Colour::Pink, rng)).collect();
        let mut samples = Vec::with_capacity(session.n_samples);
        for sample in 0..session.n_samples {
            let time_s = as_f64(sample) / session.rate_hz;
            let in_contact = sample >= N_APPROACH;
            let wobble: [f64; 3] = std::array::from_fn(|i| jitter[i].next(rng));
            let wrench =
                if in_contact { self.wrench(center_mm, &head, time_s, wobble) } else { [0.0; 6] };
            let mut reading = self.sense(wrench, (start_s + time_s) / session_s, play);
            for (channel, bias_nmm) in self.warm_nmm(planned).into_iter().enumerate() {
                reading[3 + channel] += bias_nmm;
            }
            for (channel, value) in reading.iter_mut().enumerate() {
                let std =
                    if channel < 3 { session.force_noise_n } else { session.moment_noise_nmm };
                *value += std * channels[channel].next(rng);
            }
            samples.push((start_s + time_s, reading));
        }
        // Lifting the head: the bridges see no load before the next press.
        self.sense([0.0; 6], start_s / session_s, play);
        Press { role: planned.role, commanded_mm: planned.commanded_mm, spin_hz, samples }
    }

    /// Bias of mx and my in one press.
    fn warm_nmm(&self, planned: &Planned) -> [f64; 2] {
        let highest = self.session.loads_n.iter().copied().fold(0.0, f64::max);
        let of = |fault: Fault| match fault {
            Fault::WarmLoad(bias) if planned.load_n >= highest => bias,
            _ => [0.0; 2],
        };
        let [first, second] = self.session.faults().map(of);
        [first[0] + second[0], first[1] + second[1]]
    }

    /// Where the head really goes, machine frame.
    fn center(&self, planned: &Planned, progress: f64, rng: &mut ChaCha8Rng) -> [f64; 2] {
        let offset = match planned.role {
            Role::Locate => self.session.head_offset_mm,
            _ => [0.0; 2],
        };
        let along = [planned.drag_rad.cos(), planned.drag_rad.sin()];
        let mut seats = Noise::new(self.session.seat, &mut rng.clone());
        std::array::from_fn(|axis| {
            let commanded = planned.commanded_mm[axis];
            let seat = self.session.seat_mm * seats.next(rng);
            let shift = |fault: Fault| match fault {
                Fault::FrameScale(s) => s * commanded,
                Fault::LoadShift(per_n) => per_n[axis] * (planned.load_n - REFERENCE_LOAD_N),
                Fault::Slip(mm) if planned.drag > STICKS => mm * along[axis],
                Fault::Compliance(per_n) => per_n * planned.drag * planned.load_n * along[axis],
                Fault::SpindleGrowth(end) => end[axis] * (1.0 - (-3.0 * progress).exp()),
                _ => 0.0,
            };
            let shifts = self.session.faults().map(shift);
            commanded + offset[axis] + seat + shifts[0] + shifts[1]
        })
    }

    /// The true wrench on the sensor, in its frame, moments about its reference point.
    fn wrench(&self, center_mm: [f64; 2], head: &Head, time_s: f64, jitter: [f64; 3]) -> [f64; 6] {
        let contact = head.contact(time_s, jitter);
        let offset = [
            center_mm[0] + contact.offset_mm[0] - self.sensor_mm[0],
            center_mm[1] + contact.offset_mm[1] - self.sensor_mm[1],
            0.0,
        ];
        let mut point = self.to_sensor(offset);
        point[2] = self.height_at(point[0], point[1]);
        let force = self.to_sensor(contact.force_n);
        let couple = self.to_sensor([0.0, 0.0, contact.couple_nmm]);
        let moment = add(cross(point, force), couple);
        [force[0], force[1], force[2], moment[0], moment[1], moment[2]]
    }

    /// Machine directions in the sensor's frame: turned about z, and about x by half a turn where
    /// the sensor is upside down. A proper rotation, so moments turn like forces.
    fn to_sensor(&self, v: [f64; 3]) -> [f64; 3] {
        let turned = rotate([0.0, 0.0, 1.0], -self.sensor_rad, v);
        [turned[0], self.sign * turned[1], self.sign * turned[2]]
    }

    fn height_at(&self, x: f64, y: f64) -> f64 {
        let raised = self.session.faults().map(|fault| match fault {
            Fault::ContactHeight(raised) => raised,
            Fault::PlatformTilt(slope) => slope[0] * x + slope[1] * y,
            _ => 0.0,
        });
        self.sign * PLATFORM_MM + raised[0] + raised[1]
    }

    /// What the sensor makes of a wrench.
    fn sense(&self, wrench: [f64; 6], progress: f64, play: &mut [Play; 2]) -> [f64; 6] {
        let mut reading = wrench;
        for fault in self.session.faults() {
            match fault {
                Fault::Bias(bias) => (0..6).for_each(|i| reading[i] += bias[i]),
                Fault::BiasDrift(total) => (0..6).for_each(|i| reading[i] += total[i] * progress),
                Fault::BiasSettles(total) => {
                    let come = 1.0 - (-4.0 * progress).exp();
                    (0..6).for_each(|i| reading[i] += total[i] * come);
                }
                Fault::MomentGain(gain) => (3..6).for_each(|i| reading[i] *= 1.0 + gain),
                Fault::ForceGain(gain) => reading[2] *= 1.0 + gain,
                Fault::Crosstalk(reads, leaks, factor) => reading[reads] += factor * wrench[leaks],
                Fault::Hysteresis(width) => {
                    (0..2).for_each(|i| reading[3 + i] = play[i].follow(wrench[3 + i], width));
                }
                Fault::ForceCurvature(factor) => reading[2] *= 1.0 + factor * wrench[2].abs(),
                _ => {}
            }
        }
        reading
    }
}

/// The rotating head.
struct Head {
    wobble_mm: f64,
    spin_rad_per_s: f64,
    phase_rad: f64,
    second_rad: f64,
    load_n: f64,
    drag: [f64; 2],
}

/// One instant of contact, machine frame.
struct Contact {
    offset_mm: [f64; 2],
    force_n: [f64; 3],
    couple_nmm: f64,
}

impl Head {
    fn new(session: &Session, spin_hz: f64, planned: &Planned, rng: &mut ChaCha8Rng) -> Self {
        let drag = planned.drag;
        Self {
            wobble_mm: session.wobble_mm,
            spin_rad_per_s: TAU * spin_hz,
            phase_rad: rng.random_range(0.0..TAU),
            second_rad: rng.random_range(0.0..TAU),
            load_n: planned.load_n,
            drag: [drag * planned.drag_rad.cos(), drag * planned.drag_rad.sin()],
        }
    }

    /// The pressure centre runs round once a turn because the pad leans, with a tenth of it at
    /// twice the speed, and jitters by 1 %. The load follows the lean by 2 %. The pad rubs: a
    /// couple of two thirds of the friction force at its rim, and, where the pressure centre is
    /// off the spin axis, a force across that offset.
    fn contact(&self, time_s: f64, jitter: [f64; 3]) -> Contact {
        let turn = self.phase_rad + self.spin_rad_per_s * time_s;
        let second = self.second_rad + 2.0 * turn;
        let offset_mm = [
            self.wobble_mm * (turn.cos() + 0.1 * second.cos() + 0.01 * jitter[0]),
            self.wobble_mm * (turn.sin() + 0.1 * second.sin() + 0.01 * jitter[1]),
        ];
        let load_n = self.load_n * (1.0 + 0.02 * (turn + 0.7).cos() + 0.005 * jitter[2]);
        let rub = FRICTION * load_n / PAD_RADIUS_MM;
        let force_n = [
            self.drag[0] * load_n - rub * offset_mm[1],
            self.drag[1] * load_n + rub * offset_mm[0],
            -load_n,
        ];
        Contact { offset_mm, force_n, couple_nmm: FRICTION * load_n * PAD_RADIUS_MM * 2.0 / 3.0 }
    }
}

/// Mechanical play: the output follows the input only beyond half the width.
#[derive(Clone, Copy, Debug, Default)]
struct Play {
    output: f64,
}

impl Play {
    fn follow(&mut self, input: f64, half_width: f64) -> f64 {
        self.output = self.output.clamp(input - half_width, input + half_width);
        self.output
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}

/// A press that is asked for in a session that goes on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meant {
    pub commanded_mm: [f64; 2],
    pub load_n: f64,
    /// Force across the load over the load, sensor frame.
    pub across: [f64; 2],
}

/// Makes further presses with the same rig and noise of their own, after those recorded.
pub(crate) fn press_again(
    session: &Session,
    recorded: &Recorded,
    meant: &[Meant],
    seed: u64,
) -> Vec<Press> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let sign = recorded.declared_height_mm.signum();
    let rig = Rig { session, sensor_rad: recorded.sensor_rad, sensor_mm: recorded.sensor_mm, sign };
    let (before, mut play) = (recorded.presses.len(), [Play::default(); 2]);
    let count = meant.len();
    let mut press = |(n, meant): (usize, &Meant)| {
        // Forces turn as displacements do.
        let across = [meant.across[0], sign * meant.across[1], 0.0];
        let [x, y, _] = rotate([0.0, 0.0, 1.0], rig.sensor_rad, across);
        let planned = Planned {
            role: Role::Frame,
            commanded_mm: meant.commanded_mm,
            load_n: meant.load_n,
            drag: x.hypot(y),
            drag_rad: y.atan2(x),
        };
        rig.press(before + n, before + count, &planned, &mut play, &mut rng)
    };
    meant.iter().enumerate().map(&mut press).collect()
}
