/* A head presses on a spring of 100 N/mm until the force is 30 N.
 *
 *   cargo build --release --package force-impedance-c
 *   cc -Icrates/force-impedance-c/include crates/force-impedance-c/examples/press.c \
 *      target/release/libforce_impedance_c.a -lpthread -ldl -lm -o press
 */
#include "force_impedance.h"

#include <math.h>
#include <stdio.h>

#define SPRING_N_PER_MM 100.0
#define CYCLES 1000

/* What a straight head's cells read: bracing of the legs, the contact on the axial unit, and the
 * last digit of a converter that is never quite still. */
static void read_sensors(FiMeasurement *seen, const FiPose *at, double depth_mm, int cycle) {
    double press_n = depth_mm > 0.0 ? SPRING_N_PER_MM * depth_mm : 0.0;
    double digit_n = 1e-6 * (cycle % 7);
    int i;
    for (i = 0; i < 4; ++i) {
        seen->lengths_mm[i] = at->lengths_mm[i];
        seen->cells_n[i] = i < 3 ? 100.0 + digit_n : press_n;
    }
    seen->normal[0] = 0.0;
    seen->normal[1] = 1.0;
    seen->normal[2] = 0.0;
    seen->reference_n = 30.0;
    seen->has_lengths = seen->has_cells = 1;
}

static int failed(FiError error) {
    if (error != FI_ERROR_NONE) {
        fprintf(stderr, "%s\n", fi_error_text((uint32_t)error));
    }
    return error != FI_ERROR_NONE;
}

int main(void) {
    FiHeadGeometry geometry = {120.0, 180.0, 40.0, 110.0, {1.5707963267948966, 3.6651914291880923,
                               5.7595865315812876}, 0.0, 150.0, {0.0, 0.0, -1.0}};
    FiImpedance impedance = {1.0, 1.0, 0.0};
    FiSettings settings;
    FiHead head;
    FiController controller;
    FiPose pose;
    FiMeasurement seen;
    FiCommand command;
    char text[200];
    int cycle;

    if (failed(fi_settings_default(&settings)) || failed(fi_head_init(&head, &geometry, NULL)) ||
        failed(fi_controller_init(&controller, &head, &impedance, &settings)) ||
        failed(fi_head_start(&head, &pose))) {
        return 1;
    }
    for (cycle = 0; cycle < CYCLES; ++cycle) {
        read_sensors(&seen, &pose, -300.0 - pose.tip_mm[1], cycle);
        if (failed(fi_controller_update(&controller, &seen, settings.interval_s, &command)) ||
            failed(fi_head_inverse(&head, command.tip_mm, &pose))) {
            return 1;
        }
    }
    printf("force %.1f N after %d cycles\n", command.contact.normal_n, CYCLES);
    if (command.status != FI_STATUS_CONTROLLING || fabs(command.contact.normal_n - 30.0) > 0.05) {
        return 1;
    }

    /* A refusal says why, and with which number. */
    impedance.mass_kg = -1.0;
    if (fi_explain(&geometry, NULL, &impedance, &settings, text, sizeof text) !=
        FI_ERROR_INVALID_SETTING) {
        return 1;
    }
    printf("%s\n", text);
    return 0;
}
