#define _POSIX_C_SOURCE 200809L

#include "preload/end_by_signal.h"

#include <errno.h>
#include <signal.h>
#include <stddef.h>

static void (*last_words)(void);

/* The signal is blocked until the handler returns; then its default action ends the process, as it would have. */
static void finish(int number)
{
    int error = errno;
    struct sigaction usual = {.sa_handler = SIG_DFL};
    last_words();
    (void)sigaction(number, &usual, NULL);
    (void)raise(number);
    errno = error;
}

void pinch_end_by_signal(void (*last)(void))
{
    static const int numbers[] = {SIGTERM, SIGINT};
    last_words = last;
    for (int i = 0; i < 2; i++) {
        struct sigaction now, then = {.sa_handler = finish, .sa_flags = SA_RESTART};
        if (sigaction(numbers[i], NULL, &now) != 0 || (now.sa_flags & SA_SIGINFO) || now.sa_handler != SIG_DFL)
            continue;
        (void)sigemptyset(&then.sa_mask);
        (void)sigaction(numbers[i], &then, NULL);
    }
}
