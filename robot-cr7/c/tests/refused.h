/* What a refusal must be: a status, and a text that names the argument and its value. */
#ifndef REFUSED_H
#define REFUSED_H

#include "arcfeed.h"

#include <stdio.h>
#include <string.h>

static int failures;
static int checks;

/* The call must give that status and an error that contains every given word. */
static void refused(ArcfeedStatus got, ArcfeedStatus want, const char *first, const char *second, int line) {
    const char *text = arcfeed_last_error();
    checks++;
    if (got != want || strstr(text, first) == NULL || strstr(text, second) == NULL) {
        failures++;
        fprintf(stderr, "line %d: status %d, not %d; '%s' should name '%s' and '%s'\n", line, (int)got, (int)want, text, first,
                second);
    }
}
#define REFUSED(call, status, first, second) refused(call, status, first, second, __LINE__)
#define NULL_REFUSED(call, name) refused(call, ARCFEED_NULL, name, "NULL", __LINE__)

static void must(ArcfeedStatus got, int line) {
    checks++;
    if (got != ARCFEED_OK) {
        failures++;
        fprintf(stderr, "line %d: %s\n", line, arcfeed_last_error());
    }
}
#define MUST(call) must(call, __LINE__)

static void expect(bool holds, int line) {
    checks++;
    if (!holds) {
        failures++;
        fprintf(stderr, "line %d: does not hold\n", line);
    }
}
#define EXPECT(holds) expect(holds, __LINE__)

static const ArcfeedAxisLimits LIMITS = {-1, 1, -5, 5, -50, 50};

/* Prints the numbers; the code for `main`. */
static int result(const char *of) {
    printf("%s: %d checks, %d failed\n", of, checks, failures);
    return failures == 0 ? 0 : 1;
}

#endif
