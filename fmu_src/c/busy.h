/* The flag that tells whether a call of an instance is running: only one thread gets it. */
#ifndef PSP_BUSY_H
#define PSP_BUSY_H

#include <stdbool.h>

#if defined(__GNUC__)
typedef int Busy;
static inline bool busy_change(Busy *flag, int from, int to)
{
    return __atomic_compare_exchange_n(flag, &from, to, false, __ATOMIC_ACQ_REL, __ATOMIC_RELAXED);
}
static inline void busy_put(Busy *flag, int value) { __atomic_store_n(flag, value, __ATOMIC_RELEASE); }
#elif defined(_MSC_VER)
#include <intrin.h>
typedef volatile long Busy;
static inline bool busy_change(Busy *flag, int from, int to) { return _InterlockedCompareExchange(flag, to, from) == from; }
static inline void busy_put(Busy *flag, int value) { _InterlockedExchange(flag, value); }
#else
#include <stdatomic.h>
typedef atomic_int Busy;
static inline bool busy_change(Busy *flag, int from, int to) { return atomic_compare_exchange_strong(flag, &from, to); }
static inline void busy_put(Busy *flag, int value) { atomic_store(flag, value); }
#endif

#endif
