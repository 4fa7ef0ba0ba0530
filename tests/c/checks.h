/* Checks of the test programs, in C and C++: a failed one is printed, and the program ends with 1. */

#ifndef CHECKS_H
#define CHECKS_H

#include <math.h>
#include <stdio.h>
#include <string.h>

static int failed_checks = 0;

static inline void note_check(int holds, const char *file, int line, const char *what, const char *seen) {
  if (!holds) {
    ++failed_checks;
    fprintf(stderr, "%s:%d: %s: %s\n", file, line, what, seen);
  }
}

#define CHECK(condition) note_check((condition) ? 1 : 0, __FILE__, __LINE__, #condition, "does not hold")
#define CHECK_NEAR(value, expected, tolerance) \
  note_check(fabs((value) - (expected)) <= (tolerance) ? 1 : 0, __FILE__, __LINE__, #value, "is another number than " #expected)
#define CHECK_TEXT(text, part) \
  note_check(strstr((text), (part)) != NULL ? 1 : 0, __FILE__, __LINE__, "'" part "' is missing", (text))
/* A call that fails with a status and a text with this part. */
#define CHECK_FAILS(call, expected, part)                                                   \
  do {                                                                                      \
    const clearance_status found_status = (call);                                           \
    note_check(found_status == (expected) ? 1 : 0, __FILE__, __LINE__, #call, "has another status than " #expected); \
    CHECK_TEXT(clearance_last_error(), part);                                               \
  } while (0)
#define CHECK_OK(call) \
  note_check((call) == CLEARANCE_STATUS_OK ? 1 : 0, __FILE__, __LINE__, #call, clearance_last_error())

#endif
