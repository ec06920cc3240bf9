#ifndef FORCE_IMPEDANCE_H
#define FORCE_IMPEDANCE_H

/* Written by cbindgen from the Rust source; a test says when it is out of date. */

#include <stddef.h>
#include <stdint.h>

// What a function says.
typedef enum FiError {
  // Done.
  FI_ERROR_NONE = 0,
  // A pointer is null or misaligned.
  FI_ERROR_BAD_POINTER = 1,
  // The storage was not initialised by this version of the library.
  FI_ERROR_NOT_INITIALISED = 2,
  // A setting is out of range; `fi_explain` says which.
  FI_ERROR_INVALID_SETTING = 3,
  // A vector is not of unit length.
  FI_ERROR_NOT_A_UNIT_VECTOR = 4,
  // A number is NaN or infinite.
  FI_ERROR_NOT_FINITE = 5,
  // The three legs leave a tilt of the head free.
  FI_ERROR_LEGS_DO_NOT_HOLD = 6,
  // A leg would be shorter or longer than it can be.
  FI_ERROR_LEG_OUT_OF_RANGE = 7,
  // The axial unit would be shorter or longer than it can be.
  FI_ERROR_AXIAL_OUT_OF_RANGE = 8,
  // The head would lean farther than its joint allows.
  FI_ERROR_TILT_OUT_OF_RANGE = 9,
  // The lengths fit no pose.
  FI_ERROR_FORWARD_NOT_CONVERGED = 10,
  // The impedance rings faster than the samples can follow.
  FI_ERROR_TOO_FAST_FOR_SAMPLING = 11,
  // The surface is nearly along the tool.
  FI_ERROR_NORMAL_ACROSS_AXIS = 12,
  // Something that this version of the interface has no name for.
  FI_ERROR_UNNAMED = 13,
} FiError;

// What the controller is doing.
typedef enum FiStatus {
  // The tool is in contact, the force is controlled.
  FI_STATUS_CONTROLLING = 0,
  // The tool touches nothing and approaches at no more than the approach rate.
  FI_STATUS_NO_CONTACT = 1,
  // The input is good again; output still held, or, after `hold_cycles`, moved away from the
  // workpiece while the force is above what is asked for.
  FI_STATUS_RECOVERING = 2,
  // Output held: the tip stops, and stays; `fault` says why.
  FI_STATUS_HELD = 3,
  // The tip moves away from the workpiece: the force is above what is asked for, or has not been
  // known for too long; `fault` says why.
  FI_STATUS_RETRACTING = 4,
} FiStatus;

// What is wrong with a cycle's input.
typedef enum FiFault {
  // Nothing.
  FI_FAULT_NONE = 0,
  // The interval is no number, not positive, under half or over ten times the nominal one.
  FI_FAULT_INTERVAL = 1,
  // No sample of the cells or of the lengths.
  FI_FAULT_NO_SAMPLE = 2,
  // A reading is NaN or infinite.
  FI_FAULT_NOT_FINITE = 3,
  // A cell reads more than it can.
  FI_FAULT_CELL_RANGE = 4,
  // The cells have stopped changing.
  FI_FAULT_FROZEN = 5,
  // The lengths belong to no pose.
  FI_FAULT_LENGTHS = 6,
  // The normal is no unit vector, or too far from the tool's axis.
  FI_FAULT_NORMAL = 7,
  // Something that this version of the interface has no name for.
  FI_FAULT_UNNAMED = 8,
  // A cell has stopped changing while others go on; `suspects` says which.
  FI_FAULT_CELL_STUCK = 9,
  // The cells contradict each other; `suspects` explain it best.
  FI_FAULT_CELLS_DISAGREE = 10,
} FiFault;

// What the correction is counted from.
typedef enum FiMode {
  // From where the tool stands each cycle: the force reaches its reference.
  FI_MODE_REBASED = 0,
  // From the programmed path: the spring leaves a steady error.
  FI_MODE_ABSOLUTE = 1,
} FiMode;

// How the differential equation becomes one of differences.
typedef enum FiDiscretisation {
  // The exact solution for a force error held between samples.
  FI_DISCRETISATION_EXACT_HOLD = 0,
  // The trapezoidal rule.
  FI_DISCRETISATION_BILINEAR = 1,
} FiDiscretisation;

// Bits of `FiCommand.limits`: what cut the output of a cycle.
typedef enum FiLimit {
  // The force error was saturated.
  FI_LIMIT_ERROR = 1,
  // The reference asked for was out of range or no number.
  FI_LIMIT_REFERENCE = 2,
  // The tip was kept to its speed, acceleration or jerk.
  FI_LIMIT_RATE = 4,
  // The correction was kept within its travel.
  FI_LIMIT_TRAVEL = 8,
  // The tip was kept within the head's workspace.
  FI_LIMIT_WORKSPACE = 16,
  // The head was seen outside its limits; the tip is on its way back.
  FI_LIMIT_OUTSIDE = 32,
} FiLimit;

// Dimensions of the head, frame Y: origin in the joint, the straight tool along −y.
typedef struct FiHeadGeometry {
  // L1, from the tool's contact point to the plane of the legs.
  double tip_to_plane_mm;
  // L2, from the plane of the legs to the joint, head straight.
  double plane_to_joint_mm;
  // Radius of the legs' joints on the head.
  double head_radius_mm;
  // Radius of the legs' joints on the bracket.
  double bracket_radius_mm;
  // Directions of the legs in the xz plane, from x towards z.
  double leg_angles_rad[3];
  // Weight of everything between load cells and tip.
  double weight_n;
  // Centre of gravity on the tool's axis, from the joint, head straight.
  double center_of_gravity_mm;
  // Unit vector along which things fall.
  double gravity_direction[3];
} FiHeadGeometry;

// Limits of the legs' travel.
typedef struct FiHeadLimits {
  // Shortest and longest of the three legs.
  double leg_mm[2];
  // Shortest and longest of the axial unit.
  double axial_mm[2];
  // Largest tilt of the tool from −y.
  double tilt_rad;
} FiHeadLimits;

// Storage of a head; `fi_head_init` fills it.
typedef struct FiHead {
  uint64_t mark;
  // More than there is to hold; the compiler says when they are too few.
  uint64_t words[48];
} FiHead;

// Where the head is, frame Y.
typedef struct FiPose {
  // Contact point of the tool.
  double tip_mm[3];
  // Unit vector from the joint to the tip.
  double axis[3];
  // l1, l2, l3 and the axial l4.
  double lengths_mm[4];
} FiPose;

// Contact force split along the outward normal of the surface.
typedef struct FiContact {
  // Force of the workpiece on the tool, frame Y.
  double force_n[3];
  // Along the outward normal: positive presses.
  double normal_n;
  // Across the normal: friction.
  double tangential_n;
  // Friction over normal force; NaN while nothing presses.
  double friction_ratio;
} FiContact;

// Limits and supervision of a controller; start from `fi_settings_default`.
typedef struct FiSettings {
  // Nominal sampling interval.
  double interval_s;
  // Force errors beyond ± this count as this.
  double max_error_n;
  // References are brought between 0 and this.
  double max_reference_n;
  // The reference in force approaches the one asked for at this rate.
  double reference_rate_n_per_s;
  // Largest rate at which that rate changes.
  double reference_acceleration_n_per_s2;
  // Largest rate at which that changes in turn.
  double reference_jerk_n_per_s3;
  // Least and largest correction along the normal; negative is into the workpiece.
  double travel_mm[2];
  // Fastest motion of the tip.
  double rate_mm_per_s;
  // Largest acceleration of the tip, stopping on a fault included.
  double acceleration_mm_per_s2;
  // Largest jerk of the tip.
  double jerk_mm_per_s3;
  // Fastest motion towards the workpiece while nothing is touched.
  double approach_mm_per_s;
  // Under this normal force nothing is touched.
  double contact_n;
  // Cells at ± this and beyond are broken or at their end.
  double max_cell_n;
  // Largest coefficient of friction that a contact can have.
  double max_friction_ratio;
  // Force across the normal, beyond that friction, that errors explain.
  double max_disagreement_n;
  // Farthest way towards the workpiece without any change of the axial cell, where the normal
  // is along the tool.
  double max_blind_mm;
  // Largest disagreement between measured lengths and any pose.
  double max_consistency_mm;
  // Largest angle between the outward normal and the tool's back direction.
  double max_normal_rad;
  // Cycles with all four cells unchanged to the last bit after which they count as frozen.
  uint32_t frozen_cycles;
  // Cycles for which the cells disagree, or one alone is stuck, after which it is a fault.
  uint32_t suspect_cycles;
  // Cycles for which the output is held while the force is not known, before the tip retracts.
  uint32_t hold_cycles;
  // Good cycles in a row after a fault before control resumes.
  uint32_t recovery_cycles;
  // An `FiDiscretisation`.
  uint32_t discretisation;
  // An `FiMode`.
  uint32_t mode;
} FiSettings;

// Storage of a controller; `fi_controller_init` fills it.
typedef struct FiController {
  uint64_t mark;
  // More than there is to hold; the compiler says when they are too few.
  uint64_t words[240];
} FiController;

// How the contact is to feel: `M E'' + D E' + K E = F_n − F_r`.
typedef struct FiImpedance {
  // M, positive.
  double mass_kg;
  // D, positive.
  double damping_ns_per_mm;
  // K, zero or more.
  double stiffness_n_per_mm;
} FiImpedance;

// What the sensors say in one cycle.
typedef struct FiMeasurement {
  // l1, l2, l3, l4.
  double lengths_mm[4];
  // Load cells, compression positive.
  double cells_n[4];
  // Outward unit normal of the workpiece at the programmed point, frame Y.
  double normal[3];
  // Contact force asked for.
  double reference_n;
  // Not zero when a sample of the lengths arrived.
  uint32_t has_lengths;
  // Not zero when a sample of the cells arrived.
  uint32_t has_cells;
} FiMeasurement;

// What to do until the next cycle; always finite, within limits, speed, acceleration and jerk.
typedef struct FiCommand {
  // Lengths to command, l1, l2, l3, l4.
  double lengths_mm[4];
  // Where they put the tip.
  double tip_mm[3];
  // Correction along the normal in force.
  double offset_mm;
  // Reference in force, after its ramp.
  double reference_n;
  // Contact force of this cycle; all NaN when the input was no good.
  struct FiContact contact;
  // What the controller is doing.
  enum FiStatus status;
  // Why the output is held, or the tip retracts.
  enum FiFault fault;
  // Bits of `FiLimit`.
  uint32_t limits;
  // Cycles since the output was last free.
  uint32_t held_cycles;
  // One bit per cell that the fault names, the first leg's lowest.
  uint32_t suspects;
} FiCommand;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// A code in words, a string that lives for ever; any number may be asked for.
const char *fi_error_text(uint32_t code);

// Limits for reading logs rather than for driving: a tenth to twice the length of each leg of the
// straight head, half to twice of the axial unit, 45°.
//
// # Safety
//
// Pointers are null or point at live objects of their type.
enum FiError fi_head_limits_wide(const struct FiHeadGeometry *geometry,
                                 struct FiHeadLimits *limits);

// Checks dimensions and limits (null: wide ones) and fills the storage, which holds no head after
// a refusal; a bad pointer changes nothing.
//
// # Safety
//
// Pointers are null or point at live objects of their type.
enum FiError fi_head_init(struct FiHead *head,
                          const struct FiHeadGeometry *geometry,
                          const struct FiHeadLimits *limits);

// The straight head, its tip at (0, −L1 − L2, 0).
//
// # Safety
//
// Pointers are null or point at live objects of their type.
enum FiError fi_head_start(const struct FiHead *head,
                           struct FiPose *pose);

// Inverse kinematics: the pose that brings the tip to `tip_mm` (3 numbers).
//
// # Safety
//
// Pointers are null or point at live objects of their type and count.
enum FiError fi_head_inverse(const struct FiHead *head,
                             const double *tip_mm,
                             struct FiPose *pose);

// Forward kinematics: the pose nearest to `lengths_mm` (4 numbers), and in `consistency_mm` how
// far the four disagree along the direction that no motion makes; it may be null.
//
// # Safety
//
// Pointers are null or point at live objects of their type and count.
enum FiError fi_head_forward(const struct FiHead *head,
                             const double *lengths_mm,
                             struct FiPose *pose,
                             double *consistency_mm);

// Leg Jacobian ∂(l1, l2, l3, l4)/∂tip at `tip_mm` (3 numbers): 12 numbers, row by row.
//
// # Safety
//
// Pointers are null or point at live objects of their type and count.
enum FiError fi_head_jacobian(const struct FiHead *head,
                              const double *tip_mm,
                              double *jacobian);

// Contact force from `lengths_mm` (4), `cells_n` (4, compression positive) and the outward unit
// normal of the surface (3), friction and weight included.
//
// # Safety
//
// Pointers are null or point at live objects of their type and count.
enum FiError fi_head_contact(const struct FiHead *head,
                             const double *lengths_mm,
                             const double *cells_n,
                             const double *normal,
                             struct FiContact *contact);

// Normal force by the published formula `(Σ F_i cos γ_i + F4)/cos θ`, exact without friction and
// weight only; arguments as `fi_head_contact`.
//
// # Safety
//
// Pointers are null or point at live objects of their type and count.
enum FiError fi_head_published_normal(const struct FiHead *head,
                                      const double *lengths_mm,
                                      const double *cells_n,
                                      const double *normal,
                                      double *normal_n);

// Settings of a head that presses up to 200 N at 1 kHz.
//
// # Safety
//
// The pointer is null or points at a live object.
enum FiError fi_settings_default(struct FiSettings *settings);

// Checks everything once and fills the storage; the head is copied into it.
//
// Output is held until `recovery_cycles` good cycles have been seen. Storage that held a controller
// holds none after a refusal: it has to be initialised again. A bad pointer changes nothing.
//
// # Safety
//
// Pointers are null or point at live objects of their type.
enum FiError fi_controller_init(struct FiController *controller,
                                const struct FiHead *head,
                                const struct FiImpedance *impedance,
                                const struct FiSettings *settings);

// One cycle: readings in, lengths to command out; `dt_s` is the time since the last call.
//
// It fails only on a bad or uninitialised handle and a bad `command`, which must not lie within
// the controller's storage; it may overlap `seen`, which is copied first. A null `seen` is a cycle
// without a sample. Work is bounded, nothing is allocated or locked.
//
// # Safety
//
// Pointers are null or point at live objects of their type.
enum FiError fi_controller_update(struct FiController *controller,
                                  const struct FiMeasurement *seen,
                                  double dt_s,
                                  struct FiCommand *command);

// Continues with another impedance, without a bump: position and speed carry over.
//
// # Safety
//
// Pointers are null or point at live objects of their type.
enum FiError fi_controller_set_impedance(struct FiController *controller,
                                         const struct FiImpedance *impedance);

// Counts the correction from elsewhere (an `FiMode`) from the next cycle on, without a bump.
//
// # Safety
//
// The pointer is null or points at a live object.
enum FiError fi_controller_set_mode(struct FiController *controller,
                                    uint32_t number);

// Says with numbers why dimensions, limits, impedance or settings are refused: writes UTF-8 into
// `text`, ended by a zero within `size` bytes, and returns the code that `fi_head_init` or
// `fi_controller_init` gives. An empty text where nothing is wrong. All but `geometry` may be
// null; what is null is not looked at. Not for a control cycle.
//
// # Safety
//
// Pointers are null or point at live objects of their type, `text` at `size` bytes.
enum FiError fi_explain(const struct FiHeadGeometry *geometry,
                        const struct FiHeadLimits *limits,
                        const struct FiImpedance *impedance,
                        const struct FiSettings *settings,
                        char *text,
                        size_t size);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* FORCE_IMPEDANCE_H */
