/* Checks that several tables of a scene share. */
#ifndef GALLOP_CHECK_TABLES_H
#define GALLOP_CHECK_TABLES_H

#include "check.h"

#define MAX_ITEMS 1000000 /* of a table of laws, loads, curves or gusts */
#define COUNT(array) (sizeof(array) / sizeof *(array))

/* A number of a scene, and its name in a report. */
typedef struct {
    const char *name;
    double value;
} named_number;

bool check_is_positive(double x);
int check_all_finite(const named_number *number, size_t count, gallop_report *report);
int check_all_positive(const named_number *number, size_t count, gallop_report *report);

/* An index into a table of `count`; `least` is 0, or -1 where there need be none. */
int check_index(int32_t index, int32_t least, int32_t count, const char *name,
                gallop_report *report);

/* `count` numbers of the scene from `first` on are finite, and increase where asked for. */
int check_numbers(const gallop_scene *s, int64_t first, int64_t count, bool increasing,
                  const char *name, gallop_report *report);

/* A law that something refers to. */
int check_law_of(const gallop_scene *s, int32_t index, int32_t least, const char *name,
                 gallop_report *report);

int check_field(const gallop_scene *s, const gallop_field *f, gallop_report *report);
int check_curve(const gallop_scene *s, const gallop_curve *k, gallop_report *report);

#endif
