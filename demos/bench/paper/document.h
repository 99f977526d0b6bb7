#ifndef PINCH_BENCH_PAPER_DOCUMENT_H
#define PINCH_BENCH_PAPER_DOCUMENT_H

#include "bench/bench.h"
#include "measure.h"

/* The parts of the document of `pinch bench paper --json`. Each function returns NULL where memory ran out. */

/* One row of the table: an example with a number of faces. */
typedef struct paper_row {
    const char *example;
    int faces, size; /* faces 0: no friction; size: unknowns */
    paper_pair pair;
    paper_measurement standard, lemke; /* not with --faithful */
} paper_row;

/* rows.c */
bool paper_measure_row(const bench_request *o, paper_example *e, pinch_statics *statics, int faces, paper_row *row);
json_t *paper_row_document(const paper_row *row, bool faithful, const json_t *published);
json_t *paper_measurement_document(const paper_measurement *m);
/* The published number for that quantity; NULL where none survives. faces 0: no friction. */
const json_t *paper_published_value(const json_t *published, const char *example, int faces, const char *method,
                                    const char *quantity);

#endif
