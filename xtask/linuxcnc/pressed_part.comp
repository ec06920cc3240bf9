component pressed_part "A polishing head on four legs against a spring that moves: where it stands, what its cells read";

description """
Physics of the head, six equations of equilibrium solved in every cycle; no code of the crates.

The legs follow what is commanded with a time constant.  The tip presses on a spring along the outward normal whose surface
moves to and fro, and slides with friction.  Cells and encoders have noise and a last digit.  mm, N, s, degrees; frame Y,
straight tool along \\-y, gravity along \\-z.
""";

pin in float command_#[4] "Lengths asked for, mm";
pin out float length_#[4] "Lengths read, mm";
pin out float cell_#[4] "Cells read, N";
pin out float pressed "Force of the spring on the tool along the normal, N";
pin out s32 interval "Since the cycle before, by the clock, ns";
pin out s32 clocks "The same in the clocks in which HAL counts functions";

param rw float tip_to_plane = 120 "mm";
param rw float plane_to_joint = 180 "mm";
param rw float head_radius = 40 "mm";
param rw float bracket_radius = 110 "mm";
param rw float leg_angle_#[3] "Directions of the legs, from x towards z";
param rw float weight = 0 "N";
param rw float center_of_gravity = 0 "From the joint, mm";
param rw float bracing = 300 "Sum of the legs' forces, N";
param rw float normal_#[3] "Outward unit normal";
param rw float spring = 100 "N/mm";
param rw float friction = 0.1 "Coefficient between tool and part";
param rw float surface = -0.5 "Mean place of the surface along the normal from the straight tip, mm";
param rw float stroke = 0 "Amplitude of its motion, mm";
param rw float frequency = 1 "Of its motion, Hz";
param rw float lag = 0.004 "Time constant of the legs, s";
param rw float noise = 0.05 "Of a cell, N, standard deviation";

variable double actual[4];
variable double tip[3];
variable double elapsed_s;
variable rtapi_s64 last_ns;
variable rtapi_s64 last_clocks;
variable int begun;
variable rtapi_u32 seed = 7;

function _ fp;
license "MIT OR Apache-2.0";
author "the Truing developers";
include <rtapi_math.h>;
;;

#define PI 3.14159265358979323846
#define LAST_DIGIT_MM 1e-4
#define LAST_DIGIT_N 1e-3
#define STEP_MM 1e-4

typedef struct {
    double axis[3], joint[3][3], push[3][3], length[4], center[3];
} Placed;

static void cross(const double a[3], const double b[3], double c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Turns v about the unit vector k (Rodrigues). */
static void turned(const double k[3], double sine, double cosine, const double v[3], double out[3]) {
    double c[3], along = dot(k, v) * (1.0 - cosine);
    int i;
    cross(k, v, c);
    for (i = 0; i < 3; ++i) out[i] = v[i] * cosine + c[i] * sine + k[i] * along;
}

/* The head with its tip at a point: turned by the least rotation from \-y, and moved along its axis. */
static void place(struct __comp_state *__comp_inst, const double at[3], Placed *p) {
    double straight[3] = {0.0, -1.0, 0.0}, about[3] = {1.0, 0.0, 0.0}, c[3], v[3], reach = sqrt(dot(at, at)), sine, slide;
    int leg, i;
    for (i = 0; i < 3; ++i) p->axis[i] = at[i] / reach;
    cross(straight, p->axis, c);
    sine = sqrt(dot(c, c));
    if (sine > 1e-12) for (i = 0; i < 3; ++i) about[i] = c[i] / sine;
    slide = reach - tip_to_plane - plane_to_joint;
    for (leg = 0; leg < 3; ++leg) {
        double a = leg_angle(leg) * PI / 180.0, way[3], size;
        double head[3] = {head_radius * cos(a), -plane_to_joint, head_radius * sin(a)};
        double bracket[3] = {bracket_radius * cos(a), -plane_to_joint, bracket_radius * sin(a)};
        turned(about, sine, -p->axis[1], head, v);
        for (i = 0; i < 3; ++i) {
            p->joint[leg][i] = v[i] + slide * p->axis[i];
            way[i] = p->joint[leg][i] - bracket[i];
        }
        size = sqrt(dot(way, way));
        p->length[leg] = size;
        for (i = 0; i < 3; ++i) p->push[leg][i] = way[i] / size;
    }
    p->length[3] = plane_to_joint + slide;
    for (i = 0; i < 3; ++i) p->center[i] = (center_of_gravity + slide) * p->axis[i];
}

/* Gaussian elimination with row pivoting of n rows; the last entry of a row is its right-hand side. */
static void solve(int n, double rows[7][8], double x[7]) {
    int column, row, k, best;
    for (column = 0; column < n; ++column) {
        best = column;
        for (row = column + 1; row < n; ++row)
            if (fabs(rows[row][column]) > fabs(rows[best][column])) best = row;
        for (k = 0; k <= n; ++k) {
            double other = rows[column][k];
            rows[column][k] = rows[best][k];
            rows[best][k] = other;
        }
        for (row = column + 1; row < n; ++row) {
            double factor = rows[row][column] / rows[column][column];
            for (k = column; k <= n; ++k) rows[row][k] -= factor * rows[column][k];
        }
    }
    for (row = n - 1; row >= 0; --row) {
        double known = rows[row][n];
        for (k = row + 1; k < n; ++k) known -= rows[row][k] * x[k];
        x[row] = known / rows[row][row];
    }
}

/* The tip whose lengths are nearest to those of the actuators: Gauss-Newton with differences. */
static void follow(struct __comp_state *__comp_inst) {
    int step, i, j, k;
    for (step = 0; step < 3; ++step) {
        Placed here, moved;
        double jacobian[4][3], rows[7][8], x[7];
        place(__comp_inst, tip, &here);
        for (j = 0; j < 3; ++j) {
            double at[3] = {tip[0], tip[1], tip[2]};
            at[j] += STEP_MM;
            place(__comp_inst, at, &moved);
            for (i = 0; i < 4; ++i) jacobian[i][j] = (moved.length[i] - here.length[i]) / STEP_MM;
        }
        for (j = 0; j < 3; ++j) {
            for (k = 0; k < 3; ++k) {
                rows[j][k] = 0.0;
                for (i = 0; i < 4; ++i) rows[j][k] += jacobian[i][j] * jacobian[i][k];
            }
            rows[j][3] = 0.0;
            for (i = 0; i < 4; ++i) rows[j][3] += jacobian[i][j] * (actual[i] - here.length[i]);
        }
        solve(3, rows, x);
        for (j = 0; j < 3; ++j) tip[j] += x[j];
    }
}

/* Cells that hold a force on the tip: forces, and moments about the joint, which transmits two forces across the
   axis and the moment along it; the legs are braced against each other. */
static void hold(struct __comp_state *__comp_inst, const Placed *p, const double force[3], double cells[4]) {
    double down[3] = {0.0, 0.0, -weight}, z[3] = {0.0, 0.0, 1.0}, side[3], other[3], given[3], moment[3], more[3], size;
    double rows[7][8], x[7];
    int i, leg, axis;
    cross(p->axis, z, side);
    size = sqrt(dot(side, side));
    for (i = 0; i < 3; ++i) side[i] /= size;
    cross(p->axis, side, other);
    cross(tip, force, moment);
    cross(p->center, down, more);
    for (i = 0; i < 3; ++i) {
        given[i] = force[i] + down[i];
        moment[i] += more[i];
    }
    for (axis = 0; axis < 3; ++axis) {
        for (leg = 0; leg < 3; ++leg) {
            double turn[3];
            cross(p->joint[leg], p->push[leg], turn);
            rows[axis][leg] = p->push[leg][axis];
            rows[3 + axis][leg] = turn[axis];
        }
        rows[axis][3] = p->axis[axis];
        rows[axis][4] = side[axis];
        rows[axis][5] = other[axis];
        rows[axis][6] = 0.0;
        rows[axis][7] = -given[axis];
        for (i = 3; i < 6; ++i) rows[3 + axis][i] = 0.0;
        rows[3 + axis][6] = p->axis[axis];
        rows[3 + axis][7] = -moment[axis];
    }
    for (i = 0; i < 7; ++i) rows[6][i] = i < 3 ? 1.0 : 0.0;
    rows[6][7] = bracing;
    solve(7, rows, x);
    for (i = 0; i < 4; ++i) cells[i] = x[i];
}

static double draw(struct __comp_state *__comp_inst) {
    double sum = -6.0;
    int i;
    for (i = 0; i < 12; ++i) {
        seed = seed * 1664525u + 1013904223u;
        sum += (seed >> 8) / 16777216.0;
    }
    return sum;
}

static double digit(double value, double last) { return floor(value / last + 0.5) * last; }

FUNCTION(_) {
    rtapi_s64 now_ns = rtapi_get_time(), now_clocks = rtapi_get_clocks();
    double seconds = period * 1e-9, n[3] = {normal(0), normal(1), normal(2)};
    double z[3] = {0.0, 0.0, 1.0}, slide[3], force[3], cells[4], size, out, where;
    Placed here;
    int i;
    interval = begun ? now_ns - last_ns : period;
    clocks = begun ? now_clocks - last_clocks : 0;
    last_ns = now_ns;
    last_clocks = now_clocks;
    if (!begun) {
        tip[1] = -tip_to_plane - plane_to_joint;
        place(__comp_inst, tip, &here);
        for (i = 0; i < 4; ++i) actual[i] = here.length[i];
        begun = 1;
    }
    elapsed_s += seconds;
    /* Nothing is commanded before the controller has started. */
    if (command(3) > 0.0)
        for (i = 0; i < 4; ++i) actual[i] += (command(i) - actual[i]) * (1.0 - exp(-seconds / lag));
    follow(__comp_inst);
    place(__comp_inst, tip, &here);

    out = dot(tip, n) + (tip_to_plane + plane_to_joint) * n[1];
    where = surface + stroke * sin(2.0 * PI * frequency * elapsed_s);
    pressed = where > out ? spring * (where - out) : 0.0;
    cross(n, z, slide);
    size = sqrt(dot(slide, slide));
    for (i = 0; i < 3; ++i) force[i] = pressed * (n[i] + friction * slide[i] / size);
    hold(__comp_inst, &here, force, cells);
    for (i = 0; i < 4; ++i) {
        length(i) = digit(here.length[i], LAST_DIGIT_MM);
        cell(i) = digit(cells[i] + noise * draw(__comp_inst), LAST_DIGIT_N);
    }
}
