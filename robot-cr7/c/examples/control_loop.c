/* A control loop at 1 kHz with three axes: it retargets in motion, jogs, stops on the path, holds and resumes.
 *
 *   control_loop [--fast] FOLDER
 *
 * Writes control_loop.csv and control_loop.svg to FOLDER and prints the statistics of the cycles. With --fast it does
 * not wait for the clock. */
#define _POSIX_C_SOURCE 200809L
#include "arcfeed.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { AXES = 3, CYCLES = 9000 };

static const double CYCLE = 1e-3; /* s */

/* What a plant would receive and a scope would show. */
typedef struct Sample {
    ArcfeedMotionState axes[AXES];
    const char *command;
    double scale;
} Sample;

static Sample samples[CYCLES];
static double cost_us[CYCLES];
static double late_us[CYCLES];

static void check(ArcfeedStatus status, const char *what) {
    if (status != ARCFEED_OK) {
        fprintf(stderr, "%s: %s\n", what, arcfeed_last_error());
        exit(1);
    }
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The commands of an operator, by the number of the cycle. Returns the name of the phase. */
static const char *command(ArcfeedGenerator *generator, int cycle) {
    static const char *phase = "rest";
    const ArcfeedAxisState far_away[AXES] = {{1.2, 0, 0}, {-0.8, 0, 0}, {0.5, 0, 0}};
    const ArcfeedAxisState nearer[AXES] = {{0.2, 0, 0}, {0.4, 0, 0}, {0.5, 0, 0}};
    const double jog[AXES] = {0.3, 0.0, -0.2};
    switch (cycle) {
    case 200:
        check(arcfeed_generator_set_target(generator, AXES, far_away), "target");
        return phase = "target";
    case 700: /* in motion */
        check(arcfeed_generator_set_target(generator, AXES, nearer), "another target");
        return phase = "retarget";
    case 5000:
        check(arcfeed_generator_set_target(generator, AXES, far_away), "target");
        return phase = "target";
    case 5400:
        check(arcfeed_generator_stop_on_path(generator), "stop on path");
        return phase = "stop on path";
    case 6500:
        check(arcfeed_generator_set_target(generator, AXES, far_away), "target");
        return phase = "target";
    case 6900:
        check(arcfeed_generator_hold(generator), "hold");
        return phase = "hold";
    case 7600:
        check(arcfeed_generator_resume(generator), "resume");
        return phase = "resume";
    case 7950:
        check(arcfeed_generator_stop(generator), "stop");
        return phase = "stop";
    default:
        break;
    }
    /* A jog is renewed in every cycle: it stops by itself when the pendant is silent for 20 ms. */
    if (cycle >= 3000 && cycle < 4200) {
        check(arcfeed_generator_jog(generator, AXES, jog, 0.02), "jog");
        return phase = "jog";
    }
    return phase;
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print_statistics(const char *what, double *values) {
    qsort(values, CYCLES, sizeof *values, ascending);
    printf("%-26s median %7.2f us, 99 %% %7.2f us, worst %7.2f us\n", what, values[CYCLES / 2], values[CYCLES / 100 * 99],
           values[CYCLES - 1]);
}

static FILE *open_in(const char *folder, const char *name) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    if (file == NULL) {
        perror(path);
        exit(1);
    }
    return file;
}

static void write_csv(const char *folder) {
    FILE *file = open_in(folder, "control_loop.csv");
    fprintf(file, "t_s,command,scale");
    for (int k = 1; k <= AXES; k++) {
        fprintf(file, ",p%d,v%d,a%d,j%d", k, k, k, k);
    }
    fprintf(file, "\n");
    for (int i = 0; i < CYCLES; i++) {
        fprintf(file, "%.3f,%s,%.6f", (i + 1) * CYCLE, samples[i].command, samples[i].scale);
        for (int k = 0; k < AXES; k++) {
            const ArcfeedMotionState *s = &samples[i].axes[k];
            fprintf(file, ",%.12g,%.12g,%.12g,%.12g", s->position, s->velocity, s->acceleration, s->jerk);
        }
        fprintf(file, "\n");
    }
    fclose(file);
}

static double value_of(const Sample *sample, int k, int order) {
    const ArcfeedMotionState *s = &sample->axes[k];
    return order == 0 ? s->position : order == 1 ? s->velocity : s->acceleration;
}

/* Positions, velocities and accelerations below each other, with a line where a command begins. */
static void write_svg(const char *folder) {
    static const char *const NAMES[] = {"position (rad)", "velocity (rad/s)", "acceleration (rad/s^2)"};
    static const char *const COLOURS[AXES] = {"#1f77b4", "#d62728", "#2ca02c"};
    static const double SPANS[] = {1.4, 1.2, 6.0};
    const double left = 50, width = 900, height = 150, gap = 30;
    FILE *file = open_in(folder, "control_loop.svg");
    fprintf(file, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 970 580\" font-family=\"sans-serif\" font-size=\"11\">\n");
    fprintf(file, "<rect width=\"970\" height=\"580\" fill=\"white\"/>\n");
    for (int order = 0; order < 3; order++) {
        const double middle = gap + height / 2 + order * (height + gap);
        fprintf(file, "<path d=\"M%g %gh%g\" stroke=\"#999\"/>\n", left, middle, width);
        fprintf(file, "<text x=\"%g\" y=\"%g\">%s, +-%g</text>\n", left, middle - height / 2 - 4, NAMES[order], SPANS[order]);
        for (int k = 0; k < AXES; k++) {
            fprintf(file, "<path fill=\"none\" stroke=\"%s\" d=\"", COLOURS[k]);
            for (int i = 0; i < CYCLES; i += 10) {
                const double x = left + width * i / CYCLES;
                const double y = middle - height / 2 * value_of(&samples[i], k, order) / SPANS[order];
                fprintf(file, "%s%.1f %.1f", i == 0 ? "M" : "L", x, y);
            }
            fprintf(file, "\"/>\n");
        }
    }
    for (int i = 0; i < CYCLES; i += 1000) {
        fprintf(file, "<text x=\"%g\" y=\"14\">%g s</text>\n", left + width * i / CYCLES, i * CYCLE);
    }
    for (int i = 1; i < CYCLES; i++) {
        if (strcmp(samples[i].command, samples[i - 1].command) != 0) {
            const double x = left + width * i / CYCLES;
            fprintf(file, "<path d=\"M%.1f 30V550\" stroke=\"#bbb\" stroke-dasharray=\"3\"/>\n", x);
            fprintf(file, "<text x=\"%.1f\" y=\"565\">%s</text>\n", x, samples[i].command);
        }
    }
    fprintf(file, "</svg>\n");
    fclose(file);
}

int main(int argc, char **argv) {
    const int fast = argc == 3 && strcmp(argv[1], "--fast") == 0;
    if (argc != 2 + fast) {
        fprintf(stderr, "usage: control_loop [--fast] FOLDER\n");
        return 2;
    }
    ArcfeedAxisState start[AXES];
    ArcfeedAxisLimits limits[AXES];
    ArcfeedRange ranges[AXES];
    for (int k = 0; k < AXES; k++) {
        start[k] = (ArcfeedAxisState){0, 0, 0};
        limits[k] = (ArcfeedAxisLimits){-1, 1, -5, 5, -50, 50};
        ranges[k] = (ArcfeedRange){-1.3, 1.3};
    }
    ArcfeedGenerator *generator = NULL;
    check(arcfeed_generator_new(AXES, start, limits, CYCLE, ARCFEED_SYNC_TIME, &generator), "generator");
    check(arcfeed_generator_set_ranges(generator, AXES, ranges), "ranges");

    struct timespec next;
    clock_gettime(CLOCK_MONOTONIC, &next);
    for (int i = 0; i < CYCLES; i++) {
        if (!fast) {
            next.tv_nsec += 1000000;
            if (next.tv_nsec >= 1000000000) {
                next.tv_nsec -= 1000000000;
                next.tv_sec += 1;
            }
            clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
            late_us[i] = 1e6 * (seconds() - (double)next.tv_sec - 1e-9 * (double)next.tv_nsec);
        }
        const double begin = seconds();
        samples[i].command = command(generator, i);
        check(arcfeed_generator_step(generator, AXES, samples[i].axes, NULL), "step");
        cost_us[i] = 1e6 * (seconds() - begin);
        check(arcfeed_generator_scale(generator, &samples[i].scale), "scale");
    }
    arcfeed_generator_free(generator);

    /* What the plant saw: within the limits, and no step of the acceleration beyond the jerk limit. */
    for (int i = 0; i < CYCLES; i++) {
        for (int k = 0; k < AXES; k++) {
            const ArcfeedMotionState *s = &samples[i].axes[k];
            const double before = i == 0 ? 0.0 : samples[i - 1].axes[k].acceleration;
            if (fabs(s->velocity) > 1 + 1e-9 || fabs(s->acceleration) > 5 + 1e-9 || fabs(s->position) > 1.3 + 1e-9 ||
                fabs(s->acceleration - before) > 50 * CYCLE * (1 + 1e-9) + 1e-9) {
                fprintf(stderr, "cycle %d, axis %d is outside its limits\n", i, k + 1);
                return 1;
            }
        }
    }
    write_csv(argv[argc - 1]);
    write_svg(argv[argc - 1]);
    printf("%d cycles of %g ms, %d axes\n", CYCLES, 1e3 * CYCLE, AXES);
    print_statistics("command and step", cost_us);
    if (!fast) {
        print_statistics("wake-up after its time", late_us);
    }
    return 0;
}
