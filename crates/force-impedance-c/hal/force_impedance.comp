component force_impedance "Position impedance of a polishing head on three radial legs and one axial unit";

description """
Every cycle of its thread it reads the four lengths and load cells and writes the lengths to command, so that the contact
force along the outward normal follows the reference.  Frame Y with the straight tool along \\-y; mm, N, s, rad, kg;
compression positive; legs 0 to 2 radial, 3 axial.

Set the parameters, then raise \\fBenable\\fR: they are checked once, and \\fBerror\\fR says in the numbers of FiError in
force_impedance.h what is wrong with them.  Lower and raise it to take over others.  Whatever the inputs are, the lengths
commanded stay finite, within limits, speed, acceleration and jerk; \\fBstatus\\fR (FiStatus) and \\fBfault\\fR (FiFault) say what was done.
""";

pin in bit enable "Rising: check the parameters and start; low: the output stays";
pin in float length_#[4] "Length read, mm";
pin in float cell_#[4] "Load cell read, N";
pin in float normal_#[3] "Outward unit normal of the workpiece";
pin in float reference "Contact force asked for, N";
pin out float length_out_#[4] "Length to command, mm";
pin out float offset "Correction along the normal, mm";
pin out float force "Contact force along the normal, N; 0 when the input was no good";
pin out float friction "Contact force across the normal, N; 0 when the input was no good";
pin out bit contact_ "The tool is in contact and the force is controlled";
pin out u32 status_ "FiStatus";
pin out u32 fault_ "FiFault";
pin out u32 limits_ "Bits of FiLimit";
pin out u32 suspects_ "One bit per cell that the fault names";
pin out u32 error = 2 "FiError";

param rw float tip_to_plane = 120 "L1, mm";
param rw float plane_to_joint = 180 "L2, mm";
param rw float head_radius = 40 "mm";
param rw float bracket_radius = 110 "mm";
param rw float leg_angle_#[3] "Directions of the legs in the xz plane, from x towards z, degrees; all zero: 90, 210, 330";
param rw float weight = 0 "Weight of the head, N";
param rw float center_of_gravity = 0 "From the joint, mm";
param rw float gravity_#[3] "Unit vector downwards; all zero: \\-z";
param rw float mass = 1 "M, kg";
param rw float damping = 1 "D, N s/mm";
param rw float stiffness = 0 "K, N/mm";
param rw float max_offset = 5 "Largest correction either way, mm";
param rw float max_rate = 50 "Fastest motion of the tip, mm/s";
param rw float max_acceleration = 1e4 "Largest acceleration of the tip, mm/s2";
param rw float max_jerk = 1e7 "Largest jerk of the tip, mm/s3";
param rw float approach_rate = 5 "Fastest motion inwards without contact, mm/s";
param rw float min_contact = 1 "Under this force nothing is touched, N";
param rw float max_cell = 2000 "Cells at this and beyond are broken, N";
param rw float max_friction = 1 "Largest coefficient of friction";
param rw float max_disagreement = 40 "Force across the normal, beyond friction, that errors explain, N";
param rw float max_blind = 0.25 "Farthest way inwards without a change of the axial cell, mm";
param rw u32 max_hold = 50 "Cycles held while the force is not known, before the tip retracts";

variable FiController controller;
variable hal_bit_t enabled;

function _ fp;
license "MIT OR Apache-2.0";
author "the Truing developers";
include "force_impedance.h";
;;

#define RAD_PER_DEG 0.017453292519943295

static FiError start(struct __comp_state *__comp_inst, double interval_s) {
    FiHeadGeometry geometry = {
        tip_to_plane, plane_to_joint, head_radius, bracket_radius,
        {1.5707963267948966, 3.6651914291880923, 5.7595865315812876}, /* 90, 210, 330 degrees */
        weight, center_of_gravity, {gravity(0), gravity(1), gravity(2)}};
    FiImpedance impedance = {mass, damping, stiffness};
    FiSettings settings;
    FiHead head;
    FiPose pose;
    FiError said;
    int i;

    if (gravity(0) == 0.0 && gravity(1) == 0.0 && gravity(2) == 0.0) {
        geometry.gravity_direction[2] = -1.0;
    }
    if (leg_angle(0) != 0.0 || leg_angle(1) != 0.0 || leg_angle(2) != 0.0) {
        for (i = 0; i < 3; ++i) geometry.leg_angles_rad[i] = leg_angle(i) * RAD_PER_DEG;
    }
    fi_settings_default(&settings);
    settings.interval_s = interval_s;
    settings.travel_mm[0] = -max_offset;
    settings.travel_mm[1] = max_offset;
    settings.rate_mm_per_s = max_rate;
    settings.acceleration_mm_per_s2 = max_acceleration;
    settings.jerk_mm_per_s3 = max_jerk;
    settings.approach_mm_per_s = approach_rate;
    settings.contact_n = min_contact;
    settings.max_cell_n = max_cell;
    settings.max_friction_ratio = max_friction;
    settings.max_disagreement_n = max_disagreement;
    settings.max_blind_mm = max_blind;
    settings.hold_cycles = max_hold;
    said = fi_head_init(&head, &geometry, NULL);
    if (said == FI_ERROR_NONE) said = fi_controller_init(&controller, &head, &impedance, &settings);
    if (said == FI_ERROR_NONE) said = fi_head_start(&head, &pose);
    for (i = 0; said == FI_ERROR_NONE && i < 4; ++i) length_out(i) = pose.lengths_mm[i];
    return said;
}

FUNCTION(_) {
    FiMeasurement seen;
    FiCommand command;
    double interval_s = period * 1e-9;
    int i;

    if (enable && !enabled) error = start(__comp_inst, interval_s);
    enabled = enable;
    if (!enable || error != FI_ERROR_NONE) {
        contact_ = 0;
        return;
    }
    for (i = 0; i < 4; ++i) {
        seen.lengths_mm[i] = length(i);
        seen.cells_n[i] = cell(i);
    }
    for (i = 0; i < 3; ++i) seen.normal[i] = normal(i);
    seen.reference_n = reference;
    seen.has_lengths = seen.has_cells = 1;
    error = fi_controller_update(&controller, &seen, interval_s, &command);
    if (error != FI_ERROR_NONE) return;
    for (i = 0; i < 4; ++i) length_out(i) = command.lengths_mm[i];
    offset = command.offset_mm;
    force = command.contact.normal_n == command.contact.normal_n ? command.contact.normal_n : 0.0;
    friction = command.contact.tangential_n == command.contact.tangential_n ? command.contact.tangential_n : 0.0;
    contact_ = command.status == FI_STATUS_CONTROLLING;
    status_ = command.status;
    fault_ = command.fault;
    limits_ = command.limits;
    suspects_ = command.suspects;
}
