#define _XOPEN_SOURCE 700 /* SIGXFSZ */

#include "process.h"

#include "command_status.h"

#include <fcntl.h>
#include <jansson.h>
#include <libxml/xmlmemory.h>
#include <ode/ode.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

static void end_without_memory(void)
{
    static const char message[] = "pinch: out of memory\n";
    ssize_t written = write(STDERR_FILENO, message, sizeof message - 1);
    (void)written;
    exit(COMMAND_SYSTEM);
}

static void *allocate(size_t size)
{
    void *memory = malloc(size);
    if (!memory && size > 0) end_without_memory();
    return memory;
}

#if defined(__LP64__) && !defined(__SANITIZE_ADDRESS__) /* which has operators of its own */
/* The operators new of C++, under the names that their ABI gives them. ODE is written in C++ and uses them in places,
 * and an exception of theirs would end the process without a message. */
void *pinch_operator_new(size_t size) __asm__("_Znwm");
void *pinch_operator_new_array(size_t size) __asm__("_Znam");

__attribute__((visibility("default"), used)) void *pinch_operator_new(size_t size)
{
    return allocate(size ? size : 1);
}

__attribute__((visibility("default"), used)) void *pinch_operator_new_array(size_t size)
{
    return allocate(size ? size : 1);
}
#endif

static void *reallocate(void *memory, size_t old_size, size_t size)
{
    (void)old_size;
    void *more = realloc(memory, size);
    if (!more && size > 0) end_without_memory();
    return more;
}

static void *reallocate_xml(void *memory, size_t size)
{
    return reallocate(memory, 0, size);
}

static char *duplicate_xml(const char *text)
{
    size_t size = strlen(text) + 1;
    return memcpy(allocate(size), text, size);
}

static void release(void *memory, size_t size)
{
    (void)size;
    free(memory);
}

static void pass_over(int number)
{
    (void)number;
}

/* A file that reaches a limit of the process is one that cannot be written, and is reported as such: the signal alone
 * would end the process. A program that this one becomes finds the signal as it was. */
static void report_large_files(void)
{
    struct sigaction before, action = {.sa_handler = pass_over, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    if (sigaction(SIGXFSZ, NULL, &before) == 0 && before.sa_handler == SIG_DFL) sigaction(SIGXFSZ, &action, NULL);
}

void process_prepare(void)
{
    static const int modes[3] = {O_WRONLY, O_RDONLY, O_WRONLY};
    for (int stream = 0; stream < 3; stream++)
        if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", modes[stream]) < 0) _exit(COMMAND_SYSTEM);
    report_large_files();
    json_set_alloc_funcs(allocate, free);
    xmlMemSetup(free, allocate, reallocate_xml, duplicate_xml);
    dSetAllocHandler(allocate);
    dSetReallocHandler(reallocate);
    dSetFreeHandler(release);
}

static volatile sig_atomic_t kept_signal;

static void keep(int number)
{
    kept_signal = number;
}

void process_keep_signals(void)
{
    struct sigaction action = {.sa_handler = keep, .sa_flags = (int)SA_RESETHAND};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

int process_interrupted(void)
{
    return kept_signal;
}

void process_follow_parent(int parent)
{
    kept_signal = 0;
    signal(SIGINT, SIG_IGN);
    signal(SIGTERM, SIG_DFL);
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) != 0 || getppid() != parent) _exit(COMMAND_SYSTEM);
}
