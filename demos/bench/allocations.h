/* Counts calls of the allocator in a program that is linked with --wrap=malloc, calloc and realloc. */
#ifndef PINCH_BENCH_ALLOCATIONS_H
#define PINCH_BENCH_ALLOCATIONS_H

/* How often this program and its static libraries have asked for memory. */
long allocations_counted(void);
/* Counts ODE's calls as well from here on. It must be called before ODE is used. */
void allocations_count_ode(void);

#endif
