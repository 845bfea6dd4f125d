/* Checks of the programs in C: each one that fails is printed, and check_failures counts them. */
#ifndef BRITTLE_TESTS_CHECKS_H
#define BRITTLE_TESTS_CHECKS_H

#include <stdio.h>
#include <string.h>

#include "brittle.h"

static int check_failures = 0;
static int checks = 0;

static void check(int holds, const char* what, const char* file, int line) {
    ++checks;
    if (holds) return;
    ++check_failures;
    fprintf(stderr, "%s:%d: failed: %s\n", file, line, what);
}
#define CHECK(condition) check((condition) != 0, #condition, __FILE__, __LINE__)

/* The call must fail with this status, and its message must name `word`. */
static void check_error(brittle_status got, brittle_status expected, const brittle_error* error, const char* word,
                        const char* file, int line) {
    ++checks;
    if (got == expected && error->status == expected && strstr(error->message, word)) return;
    ++check_failures;
    fprintf(stderr, "%s:%d: status %s, expected %s; message \"%s\" should contain \"%s\"\n", file, line,
            brittle_status_name(got), brittle_status_name(expected), error->message, word);
}
#define CHECK_ERROR(call, expected, word)                                                                              \
    do {                                                                                                               \
        brittle_error error;                                                                                           \
        memset(&error, 0, sizeof error);                                                                               \
        error.struct_size = sizeof error;                                                                              \
        check_error((call), (expected), &error, (word), __FILE__, __LINE__);                                           \
    } while (0)

#endif
