/* A team of two threads that share the work of one line.  The kernel starts no thread: a second
 * thread of the caller helps (gallop_assist).  A piece of work has two halves.  The first thread
 * computes one half; the thread that is free first computes the other one.  So the first thread
 * does not wait for one that has no processor.  Each half is computed by the same code in either
 * thread.
 */
#ifndef GALLOP_TEAM_H
#define GALLOP_TEAM_H

#include "gallop.h"

#include <stdbool.h>

/* Computes a half of the work, 0 or 1. */
typedef void team_work(void *task, int half);

/* Both halves; returns when they are computed.  `team` may be NULL: one thread computes both. */
void team_share_halves(gallop_team *team, team_work *work, void *task);

/* Work of one half is computed by a direct call. */
static inline void team_share(gallop_team *team, int halves, team_work *work, void *task)
{
    if (halves == 1)
        work(task, 0);
    else
        team_share_halves(team, work, task);
}

#endif
