#ifndef PINCH_COMMON_COMMAND_STATUS_H
#define PINCH_COMMON_COMMAND_STATUS_H

/* How a command ended. The values are the exit statuses of `pinch`. */
typedef enum command_status {
    COMMAND_DONE = 0,         /* done and verified */
    COMMAND_FAILED = 1,       /* it did not converge, failed verification, was infeasible, or broke a tolerance */
    COMMAND_BAD_INPUT = 2,    /* wrong usage, or a file that is not what it should be */
    COMMAND_SYSTEM = 3,       /* memory or disk ran out */
    COMMAND_INTERRUPTED = 128 /* plus the number of the signal that ended it */
} command_status;

/* Writes "pinch NAME: ..." and a line feed to standard error, as terminal_text does. At most 2,047 bytes. */
void command_error(const char *name, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Says that the file could not be written, and why, from errno (0: it is not known). Returns COMMAND_SYSTEM. */
command_status command_cannot_write(const char *name, const char *path);

#endif
