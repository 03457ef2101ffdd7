/* Two threads that share work, without locks: neither ever sleeps within a call of gallop_run. */
#if !defined(_WIN32)
#define _POSIX_C_SOURCE 200112L /* NOLINT(bugprone-reserved-identifier): POSIX has the name */
#endif
#include "base_memory.h"
#include "team.h"

#if defined(__GNUC__) && !defined(__STDC_NO_ATOMICS__)
#define TEAM_HAS_THREADS
#include <stdatomic.h>
#if defined(_WIN32)
__declspec(dllimport) int __stdcall SwitchToThread(void);
#else
#include <sched.h>
#endif
#endif

#ifdef TEAM_HAS_THREADS

#define SPINS 2000   /* some 30 us, before the processor is offered to other threads */
#define PATIENCE 500 /* spins in which the second thread takes its half, if it is there */
#define APART 64     /* [bytes] what one thread writes is not in the cache line of the other's */

/* The content of a gallop_team.  Pieces of work have numbers, from 1 on. */
typedef struct {
    char before[APART];
    atomic_uint published; /* number of the piece at hand, */
    team_work *work;       /* and what it is */
    void *task;
    bool alone; /* the second thread has not taken its half of a piece, and not been seen since */
    char between[APART];
    atomic_uint progress; /* of its second half: 2 number - 2: free; - 1: the second thread computes
                             it; 2 number: done */
    atomic_uint seen;     /* number of the last piece that the second thread has seen */
    char behind[APART];
    atomic_uint dismissed;
} pair;
_Static_assert(sizeof(pair) <= sizeof(gallop_team), "see gallop.h");

static void relax(int *spins)
{
    if (++*spins < SPINS) {
#if defined(__x86_64__) || defined(__i386__)
        __builtin_ia32_pause();
#elif defined(__aarch64__)
        __asm__ volatile("yield");
#endif
        return;
    }
#if defined(_WIN32)
    SwitchToThread();
#else
    sched_yield();
#endif
}

/* Takes the second half of a piece if it is free. */
static bool claim(pair *p, unsigned number, unsigned progress)
{
    unsigned is_free = 2 * number - 2;
    return atomic_compare_exchange_strong_explicit(&p->progress, &is_free, progress,
                                                   memory_order_acquire, memory_order_relaxed);
}

/* The second thread has its half in the caches of its processor, so it is given some time to begin;
 * one that is not there, as another program has its processor, is not waited for. */
static bool is_alone(pair *p, unsigned number)
{
    if (p->alone && number - atomic_load_explicit(&p->seen, memory_order_relaxed) > 1) return true;
    for (int spins = 0; spins < PATIENCE; relax(&spins))
        if (atomic_load_explicit(&p->progress, memory_order_relaxed) != 2 * number - 2)
            return false;
    return true;
}

void team_share_halves(gallop_team *team, team_work *work, void *task)
{
    pair *p = (pair *)team;
    if (!p) {
        work(task, 0);
        work(task, 1);
        return;
    }
    const unsigned number = atomic_load_explicit(&p->published, memory_order_relaxed) + 1;
    p->work = work;
    p->task = task;
    atomic_store_explicit(&p->published, number, memory_order_release);
    work(task, 0);

    p->alone = is_alone(p, number);
    if (p->alone && claim(p, number, 2 * number)) {
        work(task, 1);
        return;
    }
    for (int spins = 0; atomic_load_explicit(&p->progress, memory_order_acquire) != 2 * number;
         relax(&spins)) {
    }
}

/* Computes the second half of a piece, if the first thread has not begun it. */
static bool take(pair *p, unsigned number)
{
    if (!claim(p, number, 2 * number - 1)) {
        atomic_store_explicit(&p->seen, number, memory_order_relaxed);
        return false;
    }
    p->work(p->task, 1);
    atomic_store_explicit(&p->progress, 2 * number, memory_order_release);
    return true;
}

int64_t gallop_assist(gallop_team *team)
{
    if (!base_pointer_usable(team, WORD)) return -1;
    pair *p = (pair *)team;
    int64_t taken = 0;
    unsigned last = 0;
    for (int spins = 0; !atomic_load_explicit(&p->dismissed, memory_order_acquire);) {
        const unsigned number = atomic_load_explicit(&p->published, memory_order_acquire);
        if (number == last) {
            relax(&spins);
            continue;
        }
        spins = 0;
        last = number;
        taken += take(p, number);
    }
    return taken;
}

int gallop_dismiss(gallop_team *team)
{
    if (!base_pointer_usable(team, WORD)) return GALLOP_BAD_CALL;
    atomic_store_explicit(&((pair *)team)->dismissed, 1, memory_order_release);
    return GALLOP_COMPLETED;
}

#else

void team_share_halves(gallop_team *team, team_work *work, void *task)
{
    (void)team;
    work(task, 0);
    work(task, 1);
}

int64_t gallop_assist(gallop_team *team)
{
    return base_pointer_usable(team, WORD) ? 0 : -1;
}

int gallop_dismiss(gallop_team *team)
{
    return base_pointer_usable(team, WORD) ? GALLOP_COMPLETED : GALLOP_BAD_CALL;
}

#endif
