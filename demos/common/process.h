#ifndef PINCH_COMMON_PROCESS_H
#define PINCH_COMMON_PROCESS_H

/* What the command asks of its own process: open standard streams, memory, and an orderly end on a signal. */

/* Called once, before anything else.
 * A standard stream that the caller closed is opened on /dev/null, because the next file would take its number and get
 * what is written to the stream. Standard output is opened for reading only, so that writing to it still fails.
 * JSON documents, XML documents and ODE get their memory from a function that ends the process with COMMAND_SYSTEM when
 * there is none: a document that lacks a part is never printed, none is called broken that could not be read, and ODE
 * never works with a null pointer. */
void process_prepare(void);

/* From here on SIGINT and SIGTERM do not end the process but are kept for process_interrupted. A second one ends it. */
void process_keep_signals(void);

/* The signal that was kept; 0: none. */
int process_interrupted(void);

/* Runs in a new child process: the terminal's SIGINT is left to the parent, and the child ends when the parent does. */
void process_follow_parent(int parent);

#endif
