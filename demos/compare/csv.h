#ifndef PINCH_COMPARE_CSV_H
#define PINCH_COMPARE_CSV_H

#include <jansson.h>
#include <stdio.h>

/* A header line, then one row for each scene, run and metric: scene,run,metric,value,unit. Empty: there is no value. */
void csv_write(const json_t *scenes, FILE *stream);

#endif
