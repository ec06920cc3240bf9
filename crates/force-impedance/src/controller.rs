use nalgebra::{Point3, Vector3};

use crate::scalar::norm;
use crate::watch::Watch;
use crate::{
    Command, ContactForce, ControllerSettings, ForceImpedanceError, Head, HeadPose, Impedance,
    ImpedanceParameters, Limits, Measurement, ReferenceMode, Status,
};

/// Force control by position impedance along the surface normal, one call a cycle.
///
/// Everything that can be wrong with its settings is refused by [`Controller::new`];
/// [`Controller::update`] cannot fail: on bad input it holds the last safe output and says so.
/// It does not allocate, lock, or panic, and its work is bounded.
///
/// The programmed point is the tip of the straight head (the linear axes carry it along the
/// path); the correction is a number along the normal of the moment, `M1 = M + E·n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    head: Head,
    settings: ControllerSettings,
    impedance: Impedance,
    normal_cosine: f64,
    /// Commanded pose.
    pose: HeadPose,
    offset_mm: f64,
    speed_mm_per_s: f64,
    error_before_n: f64,
    reference_n: f64,
    watch: Watch,
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
            pose,
            offset_mm: 0.0,
            speed_mm_per_s: 0.0,
            error_before_n: 0.0,
            reference_n: 0.0,
            watch: Watch::new(pose),
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
        match self.watch.judge(
            &self.head,
            &self.settings,
            self.normal_cosine,
            &self.pose,
            seen,
            dt_s,
        ) {
            Ok(cells_n) => self.act(&cells_n, seen, dt_s),
            Err(fault) => self.hold(Status::Held(fault), None, Limits::default()),
        }
    }

    fn hold(&mut self, status: Status, contact: Option<ContactForce>, limits: Limits) -> Command {
        if let Status::Held(_) = status {
            self.recovery_left = self.settings.recovery_cycles;
        }
        self.speed_mm_per_s = 0.0;
        self.error_before_n = 0.0;
        self.held_cycles = self.held_cycles.saturating_add(1);
        self.command(status, contact, limits)
    }

    #[inline]
    fn act(&mut self, cells_n: &[f64; 4], seen: &Measurement, dt_s: f64) -> Command {
        let interval_s = self.settings.interval_s.min(dt_s);
        let contact = self.head.balance(&self.watch.pose).contact(cells_n, &seen.normal);
        let mut limits = Limits::default();
        self.follow_reference(seen.reference_n, interval_s, &mut limits);
        if let Some(left) = self.recovery_left.checked_sub(1) {
            self.recovery_left = left;
            return self.hold(Status::Recovering, Some(contact), limits);
        }
        self.held_cycles = 0;
        let touching = contact.normal_n >= self.settings.contact_n;
        let error_n = self.error(contact.normal_n, &mut limits);
        let (offset_mm, speed_mm_per_s) = self.impede(error_n);
        self.error_before_n = error_n;
        let inward_mm_per_s =
            if touching { self.settings.rate_mm_per_s } else { self.settings.approach_mm_per_s };
        let wanted_mm = self.bound(offset_mm, inward_mm_per_s, interval_s, &mut limits);
        self.travel(wanted_mm, speed_mm_per_s, &seen.normal, interval_s, &mut limits);
        let status = if touching { Status::Controlling } else { Status::NoContact };
        self.command(status, Some(contact), limits)
    }

    /// Moves the reference in force towards the one asked for; one that is no number is ignored.
    #[inline]
    fn follow_reference(&mut self, asked_n: f64, interval_s: f64, limits: &mut Limits) {
        let within_n = between(asked_n, 0.0, self.settings.max_reference_n);
        let valid = asked_n.is_finite();
        limits.set(Limits::REFERENCE, !valid || asked_n < 0.0 || asked_n > within_n);
        if valid {
            let step_n = self.settings.reference_rate_n_per_s * interval_s;
            self.reference_n =
                between(within_n, self.reference_n - step_n, self.reference_n + step_n);
        }
    }

    #[inline]
    fn error(&self, normal_n: f64, limits: &mut Limits) -> f64 {
        let raw_n = normal_n - self.reference_n;
        let most_n = self.settings.max_error_n;
        limits.set(Limits::ERROR, raw_n.abs() > most_n);
        between(raw_n, -most_n, most_n)
    }

    /// One step of the impedance: offset and speed after it.
    #[inline]
    fn impede(&self, error_n: f64) -> (f64, f64) {
        let from_mm = match self.settings.mode {
            ReferenceMode::Absolute => 0.0,
            ReferenceMode::Rebased => self.offset_mm,
        };
        let [moved_mm, speed_mm_per_s] = self.impedance.advance(
            self.offset_mm - from_mm,
            self.speed_mm_per_s,
            error_n,
            self.error_before_n,
        );
        (from_mm + moved_mm, speed_mm_per_s)
    }

    /// The offset within rate and travel.
    #[inline]
    fn bound(
        &self,
        offset_mm: f64,
        inward_mm_per_s: f64,
        interval_s: f64,
        limits: &mut Limits,
    ) -> f64 {
        let lowest_mm = self.offset_mm - inward_mm_per_s * interval_s;
        let highest_mm = self.offset_mm + self.settings.rate_mm_per_s * interval_s;
        limits.set(Limits::RATE, offset_mm < lowest_mm || offset_mm > highest_mm);
        let slow_mm = between(offset_mm, lowest_mm, highest_mm);
        let [inward_mm, outward_mm] = self.settings.travel_mm;
        limits.set(Limits::TRAVEL, slow_mm < inward_mm || slow_mm > outward_mm);
        between(slow_mm, inward_mm, outward_mm)
    }

    /// Moves the commanded tip towards `M + E·n`, within rate and workspace, and takes back into
    /// the state what was cut off, so that nothing winds up.
    #[inline]
    fn travel(
        &mut self,
        wanted_mm: f64,
        speed_mm_per_s: f64,
        normal: &Vector3<f64>,
        interval_s: f64,
        limits: &mut Limits,
    ) {
        let programmed_mm = self.head.start_tip_mm();
        let way_mm = programmed_mm + normal * wanted_mm - self.pose.tip_mm;
        let longest_mm = self.settings.rate_mm_per_s * interval_s;
        let far = way_mm.dot(&way_mm) > longest_mm * longest_mm;
        limits.set(Limits::RATE, far);
        let step_mm = if far { way_mm * (longest_mm / norm(&way_mm)) } else { way_mm };
        let tip_mm: Point3<f64> = self.pose.tip_mm + step_mm;
        let pose = HeadPose::of(&self.head, &tip_mm.coords);
        let reached = self.head.allows(&pose);
        limits.set(Limits::WORKSPACE, !reached);
        let before_mm = self.offset_mm;
        if reached {
            self.pose = pose;
        }
        let cut = far || !reached;
        self.offset_mm = if cut {
            let [inward_mm, outward_mm] = self.settings.travel_mm;
            between((self.pose.tip_mm - programmed_mm).dot(normal), inward_mm, outward_mm)
        } else {
            wanted_mm
        };
        let free = !(limits.rate() || limits.travel() || limits.workspace());
        self.speed_mm_per_s = if free {
            speed_mm_per_s
        } else {
            (self.offset_mm - before_mm) / self.settings.interval_s
        };
    }

    #[inline]
    fn command(&self, status: Status, contact: Option<ContactForce>, limits: Limits) -> Command {
        Command {
            lengths_mm: self.pose.lengths_mm,
            tip_mm: self.pose.tip_mm,
            offset_mm: self.offset_mm,
            reference_n: self.reference_n,
            contact,
            status,
            limits,
            held_cycles: self.held_cycles,
        }
    }
}

/// `f64::clamp` without its panic; `high` wins where the two are crossed, `low` where `x` is NaN.
#[inline]
fn between(x: f64, low: f64, high: f64) -> f64 {
    let above = if x > low { x } else { low };
    if above < high { above } else { high }
}
