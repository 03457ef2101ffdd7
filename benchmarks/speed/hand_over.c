/* Time in which a cache line goes from one core to another one and back, compiled together with the
 * kernel by line_threads.py.  On a virtual machine it depends on where its cores are. */
#define _POSIX_C_SOURCE 200112L
#include "gallop.h"

#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

#define ROUNDS 100000

typedef struct {
    atomic_int asked;
    char apart[128];
    atomic_int answered;
} lines;

static void *answer(void *argument)
{
    lines *l = argument;
    for (int i = 1; i <= ROUNDS; i++) {
        while (atomic_load_explicit(&l->asked, memory_order_acquire) != i) continue;
        atomic_store_explicit(&l->answered, i, memory_order_release);
    }
    return NULL;
}

/* Microseconds; negative: no thread could be started. */
GALLOP_API double hand_over(void)
{
    static lines l;
    pthread_t second;
    struct timespec began, ended;
    l.asked = l.answered = 0;
    if (pthread_create(&second, NULL, answer, &l)) return -1.0;
    clock_gettime(CLOCK_MONOTONIC, &began);
    for (int i = 1; i <= ROUNDS; i++) {
        atomic_store_explicit(&l.asked, i, memory_order_release);
        while (atomic_load_explicit(&l.answered, memory_order_acquire) != i) continue;
    }
    clock_gettime(CLOCK_MONOTONIC, &ended);
    pthread_join(second, NULL);
    return ((double)(ended.tv_sec - began.tv_sec) * 1e6 +
            1e-3 * (double)(ended.tv_nsec - began.tv_nsec)) /
           ROUNDS;
}
