component touched_part "A touch probe over a reference sphere and a freeform part: where its switch closes";

description """
Physics of a probe with three seats under a spring, a stylus that bends, and a ball on two surfaces; no code of the crates.

The ball meets a surface between two cycles.  From there on the machine moves the stylus on: the ball sticks or slides by
Coulomb's law, the stylus bends, and the switch opens when the moment about two of the three seats, or the force along the
stylus, lifts it off the third.  The electronics say so a while later, and the controller hears it in its next cycle.
mm, N, s; N/mm; angles in degrees.
""";

pin in float axis_#[3] "Where the axes are, mm: the ball's centre";
pin out bit closed "The probe's input";
pin out float gap "Distance of the ball from the nearer surface, mm; below 0 the stylus bends";
pin out float travel "Way of the machine from contact to switch in the last touch, mm: pretravel";

param rw float ball = 3 "Radius, mm";
param rw float latency = 0 "From switch to input, s";
param rw float scatter = 0 "Repeatability of the switch, mm, standard deviation";
param rw float seats = 8 "Radius on which the three seats are, mm; the first in x";
param rw float preload = 1 "Spring, N";
param rw float stylus = 40 "From the seats to the ball, mm";
param rw float bending = 15 "Stiffness of the stylus across its axis, N/mm";
param rw float axial = 600 "Stiffness along it, N/mm";
param rw float friction = 0.2 "Coefficient between ball and surface";
param rw float sphere_radius = 12.5 "mm";
param rw float sphere_#[3] "Centre of the sphere, mm";
param rw float place_#[3] "Where the part's origin lies, mm";
param rw float turn_#[3] "Rotations of the part about x, y, z, degrees, x first";
param rw float saddle = 0 "Clamping: height at 40 mm in x and below at 30 mm in y, mm";
param rw float bump = 0 "Height at (\\-18, 10), falling off within 8 mm, mm";
param rw float ripple = 0 "Amplitude of the marks of the tool, 14 mm apart along (1, 1), mm";

variable double last[3];
variable double last_gap = 1;
variable double now_s;
variable double due_s;
variable int met;
variable rtapi_u32 seed = 20240117;

function _ fp;
license "MIT OR Apache-2.0";
author "the Truing developers";
include <rtapi_math.h>;
;;

#define PI 3.14159265358979323846
#define FOOT_STEPS 20
#define SLIP_STEPS 400

/* The part as drawn, and as it was made, over its own x and y. */
static double height(struct __comp_state *__comp_inst, double x, double y) {
    double u = x / 40.0, v = y / 40.0, dx = x + 18.0, dy = y - 10.0;
    double drawn = -6.0 * u * u - 8.0 * v * v + 2.0 * u * v + 1.5 * u * u * u - v * v * v + 1.2 * u * u * v;
    double bent = saddle * (u * u - y * y / 900.0);
    double hump = bump * exp(-2.0 * (dx * dx + dy * dy) / 64.0);
    return drawn + bent + hump + ripple * sin(2.0 * PI * (x + y) / (14.0 * sqrt(2.0)));
}

static void slopes(struct __comp_state *__comp_inst, double x, double y, double s[2]) {
    double h = 1e-3;
    s[0] = (height(__comp_inst, x + h, y) - height(__comp_inst, x - h, y)) / (2.0 * h);
    s[1] = (height(__comp_inst, x, y + h) - height(__comp_inst, x, y - h)) / (2.0 * h);
}

/* Rows of Rz Ry Rx. */
static void rotation(struct __comp_state *__comp_inst, double r[3][3]) {
    double a = turn(0) * PI / 180.0, b = turn(1) * PI / 180.0, c = turn(2) * PI / 180.0;
    double sa = sin(a), ca = cos(a), sb = sin(b), cb = cos(b), sc = sin(c), cc = cos(c);
    r[0][0] = cc * cb; r[0][1] = cc * sb * sa - sc * ca; r[0][2] = cc * sb * ca + sc * sa;
    r[1][0] = sc * cb; r[1][1] = sc * sb * sa + cc * ca; r[1][2] = sc * sb * ca - cc * sa;
    r[2][0] = -sb;     r[2][1] = cb * sa;                r[2][2] = cb * ca;
}

/* Distance of a point from the part and the outward normal at its foot, machine frame. */
static double from_part(struct __comp_state *__comp_inst, const double at[3], double normal[3]) {
    double r[3][3], p[3], s[2], x, y, dz, n[3], length, side;
    int i, k;
    rotation(__comp_inst, r);
    for (i = 0; i < 3; ++i) {
        p[i] = 0.0;
        for (k = 0; k < 3; ++k) p[i] += r[k][i] * (at[k] - place(k));
    }
    x = p[0];
    y = p[1];
    /* The foot is where the normal leads back to the point. */
    for (i = 0; i < FOOT_STEPS; ++i) {
        slopes(__comp_inst, x, y, s);
        dz = p[2] - height(__comp_inst, x, y);
        x += (p[0] - x + dz * s[0]) / (1.0 + s[0] * s[0]) * 0.9;
        y += (p[1] - y + dz * s[1]) / (1.0 + s[1] * s[1]) * 0.9;
    }
    slopes(__comp_inst, x, y, s);
    length = sqrt(1.0 + s[0] * s[0] + s[1] * s[1]);
    n[0] = -s[0] / length;
    n[1] = -s[1] / length;
    n[2] = 1.0 / length;
    side = (p[0] - x) * n[0] + (p[1] - y) * n[1] + (p[2] - height(__comp_inst, x, y)) * n[2];
    for (i = 0; i < 3; ++i) {
        normal[i] = 0.0;
        for (k = 0; k < 3; ++k) normal[i] += r[i][k] * n[k];
    }
    return side;
}

static double from_sphere(struct __comp_state *__comp_inst, const double at[3], double normal[3]) {
    double length = 0.0;
    int i;
    for (i = 0; i < 3; ++i) {
        normal[i] = at[i] - sphere(i);
        length += normal[i] * normal[i];
    }
    length = sqrt(length);
    for (i = 0; i < 3; ++i) normal[i] /= length;
    return length - sphere_radius;
}

/* Force on the ball for each mm that the machine moves along `way`: what the stylus' stiffness makes of the
   way less the ball's slip, where friction allows no more than its share of the normal force. */
static void force_per_mm(struct __comp_state *__comp_inst, const double way[3], const double n[3], double f[3]) {
    double stiff[3] = {bending, bending, axial};
    double slip[3] = {0.0, 0.0, 0.0}, across[3], normal_force, over, size;
    int step, i;
    for (step = 0; step < SLIP_STEPS; ++step) {
        normal_force = 0.0;
        for (i = 0; i < 3; ++i) {
            f[i] = -stiff[i] * (way[i] - slip[i]);
            normal_force += f[i] * n[i];
        }
        size = 0.0;
        for (i = 0; i < 3; ++i) {
            across[i] = f[i] - normal_force * n[i];
            size += across[i] * across[i];
        }
        size = sqrt(size);
        over = size - friction * (normal_force > 0.0 ? normal_force : 0.0);
        if (over <= 1e-9 * axial) break;
        for (i = 0; i < 3; ++i) slip[i] -= across[i] / size * over / axial;
    }
}

/* Way of the machine from contact until one seat is free. */
static double pretravel(struct __comp_state *__comp_inst, const double way[3], const double n[3]) {
    double f[3], most = 0.0, tips;
    int seat;
    force_per_mm(__comp_inst, way, n, f);
    for (seat = 0; seat < 3; ++seat) {
        double towards = 2.0 * PI * seat / 3.0;
        /* About the other two seats, half a radius behind: the side force on its arm and the push upwards
           against the spring. */
        tips = (f[0] * cos(towards) + f[1] * sin(towards)) * stylus + f[2] * seats / 2.0;
        if (tips > most) most = tips;
    }
    return most > 0.0 ? preload * seats / 2.0 / most : 1.0;
}

static double even(struct __comp_state *__comp_inst) {
    seed = seed * 1664525u + 1013904223u;
    return (seed >> 8) / 16777216.0;
}

/* Sum of twelve even ones: standard deviation 1. */
static double normal_draw(struct __comp_state *__comp_inst) {
    double sum = -6.0;
    int i;
    for (i = 0; i < 12; ++i) sum += even(__comp_inst);
    return sum;
}

FUNCTION(_) {
    double at[3], n[3], other[3], way[3], interval = period * 1e-9, speed = 0.0, near, part;
    int i;
    now_s += interval;
    for (i = 0; i < 3; ++i) at[i] = axis(i);
    near = from_sphere(__comp_inst, at, n);
    /* Away from the part its foot means nothing. */
    part = axis(0) > -70.0 ? from_part(__comp_inst, at, other) : 1e3;
    if (part < near) {
        near = part;
        for (i = 0; i < 3; ++i) n[i] = other[i];
    }
    gap = near - ball;
    if (gap > 0.0) {
        met = 0;
        closed = 0;
    } else if (!met) {
        met = 1;
        for (i = 0; i < 3; ++i) {
            way[i] = at[i] - last[i];
            speed += way[i] * way[i];
        }
        speed = sqrt(speed) / interval;
        due_s = now_s;
        if (speed > 0.0 && last_gap > 0.0) {
            for (i = 0; i < 3; ++i) way[i] /= speed * interval;
            travel = pretravel(__comp_inst, way, n) + scatter * normal_draw(__comp_inst);
            due_s += interval * gap / (last_gap - gap) + travel / speed + latency;
        }
    }
    if (met && now_s >= due_s) closed = 1;
    for (i = 0; i < 3; ++i) last[i] = at[i];
    last_gap = gap;
}
