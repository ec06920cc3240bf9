use nalgebra::{Point3, Vector3};

use crate::motion::{Motion, MotionLimits};
use crate::ramp::Ramp;
use crate::redundancy::Redundancy;
use crate::scalar::between;
use crate::steering::{Steering, Wanted};
use crate::watch::{Refusal, Watch};
use crate::{
    Command, ContactForce, ControllerSettings, Fault, ForceImpedanceError, Head, HeadPose,
    Impedance, ImpedanceParameters, Limits, Measurement, ReferenceMode, Status,
};

/// Force control by position impedance along the surface normal, one call a cycle.
///
/// Everything that can be wrong with its settings is refused by [`Controller::new`];
/// [`Controller::update`] cannot fail: on bad input it stops, away from the workpiece where the
/// force is above what is asked for or not known, and says so. Commands keep speed, acceleration
/// and jerk in every state. It does not allocate, lock, or panic, and its work is bounded.
///
/// The programmed point is the tip of the straight head (the linear axes carry it along the
/// path); the correction is a number along the normal of the moment, `M1 = M + E·n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    head: Head,
    settings: ControllerSettings,
    impedance: Impedance,
    normal_cosine: f64,
    steering: Steering,
    reference_limits: MotionLimits,
    /// Commanded pose, and how it moves.
    pose: HeadPose,
    motion: Motion,
    /// Of the last cycle in which it could be believed, of unit length.
    normal: Vector3<f64>,
    offset_mm: f64,
    speed_mm_per_s: f64,
    error_before_n: f64,
    reference: Ramp,
    /// What was last asked for, within its range.
    asked_n: f64,
    watch: Watch,
    redundancy: Redundancy,
    /// Good cycles still to come before control resumes.
    recovery_left: u32,
    held_cycles: u32,
}

impl Controller {
    /// Checks everything once. The head starts straight, its output held until
    /// `recovery_cycles` good cycles have been seen.
    ///
    /// # Errors
    ///
    /// [`ForceImpedanceError::InvalidSetting`], [`ForceImpedanceError::TooFastForSampling`], and
    /// the out-of-range errors of [`Head::pose_at`] when the straight head is beyond its limits.
    pub fn new(
        head: Head,
        parameters: ImpedanceParameters,
        settings: ControllerSettings,
    ) -> Result<Self, ForceImpedanceError> {
        settings.check()?;
        let impedance = Impedance::new(parameters, settings.interval_s, settings.discretisation)?;
        let pose = head.pose_at(&head.start_tip_mm())?;
        Ok(Self {
            head,
            settings,
            impedance,
            normal_cosine: libm::cos(settings.max_normal_rad),
            steering: Steering::new(&head, &settings),
            reference_limits: settings.reference_motion(),
            pose,
            motion: Motion::default(),
            normal: Vector3::new(0.0, 1.0, 0.0),
            offset_mm: 0.0,
            speed_mm_per_s: 0.0,
            error_before_n: 0.0,
            reference: Ramp::at(0.0),
            asked_n: 0.0,
            watch: Watch::new(pose),
            redundancy: Redundancy::NEW,
            recovery_left: settings.recovery_cycles,
            held_cycles: 0,
        })
    }

    /// The head it drives.
    #[must_use]
    pub const fn head(&self) -> &Head {
        &self.head
    }

    /// Settings it was made with.
    #[must_use]
    pub const fn settings(&self) -> &ControllerSettings {
        &self.settings
    }

    /// Checks and computes other parameters for this controller's interval, outside the
    /// real-time path.
    ///
    /// # Errors
    ///
    /// As [`Impedance::new`].
    pub fn prepare(
        &self,
        parameters: ImpedanceParameters,
    ) -> Result<Impedance, ForceImpedanceError> {
        Impedance::new(parameters, self.settings.interval_s, self.settings.discretisation)
    }

    /// Continues with other parameters, without a bump: position and speed carry over.
    ///
    /// # Errors
    ///
    /// [`ForceImpedanceError::InvalidSetting`] when they were prepared for another interval.
    pub fn adopt(&mut self, impedance: Impedance) -> Result<(), ForceImpedanceError> {
        if impedance.interval_s.to_bits() == self.settings.interval_s.to_bits() {
            self.impedance = impedance;
            return Ok(());
        }
        Err(ForceImpedanceError::InvalidSetting {
            setting: "interval_s of the impedance",
            value: impedance.interval_s,
            needs: "that of the controller: use Controller::prepare",
        })
    }

    /// Counts the correction from elsewhere from the next cycle on, without a bump.
    pub fn set_mode(&mut self, mode: ReferenceMode) {
        self.settings.mode = mode;
    }

    /// One cycle: readings in, lengths to command out. `dt_s` is the time since the last call.
    #[inline]
    pub fn update(&mut self, seen: &Measurement, dt_s: f64) -> Command {
        let inward_mm = -self.motion.step.dot(&self.normal);
        match self.watch.judge(
            &self.head,
            &self.settings,
            self.normal_cosine,
            &self.pose,
            inward_mm,
            seen,
            dt_s,
        ) {
            Ok(cells_n) => self.act(&cells_n, seen, dt_s),
            Err(refusal) => self.fail(&refusal),
        }
    }

    /// A cycle whose input is not believed: the tip stops, or retracts.
    #[cold]
    fn fail(&mut self, refusal: &Refusal) -> Command {
        let fault = refusal.fault;
        self.recovery_left = self.settings.recovery_cycles;
        self.reference.stop(&self.reference_limits);
        let retracts = match (&refusal.cells_n, fault) {
            // The head is about where it was sent.
            (Some(cells_n), _) => {
                let contact = self.head.balance(&self.pose).contact(cells_n, &self.normal);
                self.is_too_much(contact.normal_n)
            }
            (None, Fault::CellStuck(_) | Fault::CellsDisagree(_)) => true,
            (None, _) => self.held_cycles >= self.settings.hold_cycles,
        };
        let mut limits = Limits::default();
        self.wait(retracts, &mut limits);
        let status = if retracts { Status::Retracting(fault) } else { Status::Held(fault) };
        self.command(status, None, limits)
    }

    /// Whether a force is above what is asked for, by more than what counts as a contact.
    #[inline]
    fn is_too_much(&self, normal_n: f64) -> bool {
        normal_n > self.asked_n.max(self.reference.value) + self.settings.contact_n
    }

    /// Stops, or moves away from the workpiece.
    fn wait(&mut self, retracts: bool, limits: &mut Limits) {
        self.held_cycles = self.held_cycles.saturating_add(1);
        self.error_before_n = 0.0;
        let change = if retracts {
            let wanted = Wanted {
                normal: self.normal,
                along_mm: self.steering.motion.step,
                inward_mm: 0.0,
                fastest_mm: self.steering.motion.step,
                returns: false,
            };
            // Where the head is seen takes no part: its lengths may be what is wrong.
            self.steer(&wanted, &self.pose, None, limits)
        } else if self.motion.is_at_rest() {
            self.speed_mm_per_s = 0.0;
            return;
        } else {
            self.steering.brake(&self.head, &self.pose, &self.motion, &self.normal)
        };
        limits.set(Limits::RATE, true);
        self.go(change, limits);
        self.offset_mm = self.offset(&self.normal);
        self.speed_mm_per_s = self.motion.step.dot(&self.normal) / self.settings.interval_s;
    }

    #[inline]
    fn act(&mut self, cells_n: &[f64; 4], seen: &Measurement, dt_s: f64) -> Command {
        let share = (dt_s / self.settings.interval_s).min(1.0);
        // Of unit length to the square of what `Watch` lets pass.
        self.normal = seen.normal * (1.5 - 0.5 * seen.normal.dot(&seen.normal));
        let normal = self.normal;
        let balance = self.head.balance(&self.watch.pose);
        let contact = balance.contact(cells_n, &normal);
        let suspects = self.redundancy.judge(&self.settings, &balance, &contact, cells_n, &normal);
        if let Some(cells) = suspects {
            return self.fail(&Refusal { fault: Fault::CellsDisagree(cells), cells_n: None });
        }
        let mut limits = Limits::default();
        self.follow_reference(seen.reference_n, share, &mut limits);
        if let Some(left) = self.recovery_left.checked_sub(1) {
            self.recovery_left = left;
            // Once in a while is no reason to move; bad and good cycles in turn, for ever, are.
            let long = self.held_cycles >= self.settings.hold_cycles;
            self.wait(long && self.is_too_much(contact.normal_n), &mut limits);
            return self.command(Status::Recovering, Some(contact), limits);
        }
        self.held_cycles = 0;
        let touching = contact.normal_n >= self.settings.contact_n;
        let error_n = self.error(contact.normal_n, &mut limits);
        self.control(error_n, touching, share, &mut limits);
        let status = if touching { Status::Controlling } else { Status::NoContact };
        self.command(status, Some(contact), limits)
    }

    /// Moves the reference in force towards the one asked for; one that is no number is ignored.
    #[inline]
    fn follow_reference(&mut self, asked_n: f64, share: f64, limits: &mut Limits) {
        let within_n = between(asked_n, 0.0, self.settings.max_reference_n);
        let valid = asked_n.is_finite();
        limits.set(Limits::REFERENCE, !valid || asked_n < 0.0 || asked_n > within_n);
        if valid {
            self.asked_n = within_n;
        }
        self.reference.follow(&self.reference_limits, self.asked_n, share);
    }

    #[inline]
    fn error(&self, normal_n: f64, limits: &mut Limits) -> f64 {
        let raw_n = normal_n - self.reference.value;
        let most_n = self.settings.max_error_n;
        limits.set(Limits::ERROR, raw_n.abs() > most_n);
        between(raw_n, -most_n, most_n)
    }

    /// One step of the impedance, as far as the motion of the tip allows; what is cut off is taken
    /// back into the state, so that nothing winds up.
    #[inline]
    fn control(&mut self, error_n: f64, touching: bool, share: f64, limits: &mut Limits) {
        let normal = self.normal;
        let stands_mm = self.offset(&normal);
        let (offset_mm, speed_mm_per_s) = self.impede(stands_mm, error_n);
        self.error_before_n = error_n;
        let [inward_mm, outward_mm] = self.settings.travel_mm;
        limits.set(Limits::TRAVEL, offset_mm < inward_mm || offset_mm > outward_mm);
        let wanted_mm = between(offset_mm, inward_mm, outward_mm);
        let per_s = self.settings.interval_s * share;
        let fastest_mm = self.settings.rate_mm_per_s * per_s;
        let wanted = Wanted {
            normal,
            along_mm: wanted_mm - stands_mm,
            inward_mm: if touching { fastest_mm } else { self.settings.approach_mm_per_s * per_s },
            fastest_mm,
            returns: error_n <= 0.0,
        };
        let exact_mm = self.head.start_tip_mm() + normal * wanted_mm - self.pose.tip_mm;
        let change = self.steer(&wanted, &self.watch.pose, Some(&exact_mm), limits);
        let free =
            self.go(change, limits) && !(limits.rate() || limits.travel() || limits.workspace());
        if free {
            self.offset_mm = wanted_mm;
            self.speed_mm_per_s = speed_mm_per_s;
        } else {
            self.offset_mm = self.offset(&normal);
            self.speed_mm_per_s = self.motion.step.dot(&normal) / self.settings.interval_s;
        }
    }

    #[inline]
    fn steer(
        &self,
        wanted: &Wanted,
        seen: &HeadPose,
        exact_mm: Option<&Vector3<f64>>,
        limits: &mut Limits,
    ) -> Vector3<f64> {
        self.steering.steer(&self.head, &self.pose, seen, &self.motion, wanted, exact_mm, limits)
    }

    /// Correction along a normal, of where the tip stands.
    #[inline]
    fn offset(&self, normal: &Vector3<f64>) -> f64 {
        (self.pose.tip_mm - self.head.start_tip_mm()).dot(normal)
    }

    /// One step of the impedance: offset and speed after it.
    #[inline]
    fn impede(&self, stands_mm: f64, error_n: f64) -> (f64, f64) {
        let from_mm = match self.settings.mode {
            ReferenceMode::Absolute => 0.0,
            ReferenceMode::Rebased => stands_mm,
        };
        let [moved_mm, speed_mm_per_s] = self.impedance.advance(
            stands_mm - from_mm,
            self.speed_mm_per_s,
            error_n,
            self.error_before_n,
        );
        (from_mm + moved_mm, speed_mm_per_s)
    }

    /// Moves the commanded tip; false where it would leave the head's limits, which
    /// [`Workspace`](crate::workspace::Workspace) rules out: they count before its acceleration.
    #[inline]
    fn go(&mut self, change: Vector3<f64>, limits: &mut Limits) -> bool {
        let motion = self.motion.after(change);
        let tip_mm: Point3<f64> = self.pose.tip_mm + motion.step;
        let pose = HeadPose::of(&self.head, &tip_mm.coords);
        let reached = self.head.allows(&pose);
        limits.set(Limits::WORKSPACE, !reached);
        if reached {
            self.pose = pose;
            self.motion = motion;
        } else {
            self.motion = self.motion.after(-self.motion.step);
        }
        reached
    }

    #[inline]
    fn command(&self, status: Status, contact: Option<ContactForce>, limits: Limits) -> Command {
        let [inward_mm, outward_mm] = self.settings.travel_mm;
        Command {
            lengths_mm: self.pose.lengths_mm,
            tip_mm: self.pose.tip_mm,
            offset_mm: between(self.offset_mm, inward_mm, outward_mm),
            reference_n: self.reference.value,
            contact,
            status,
            limits,
            held_cycles: self.held_cycles,
        }
    }
}
