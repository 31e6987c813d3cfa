/* What certifies a sampling period. */
#ifndef PSP_CERTIFICATE_H
#define PSP_CERTIFICATE_H

#include "cooperation.h"

enum { CERTIFICATE_LEMMA1 = 1, CERTIFICATE_EXACT = 2 };

/* T_max of Lemma 1 and T_exact for n vehicles under accelerations that are about to be held; lengths are those of the
 * cooperation, all L where it is NULL; the own speed of a first vehicle that drives itself, `driven`, sets no bound. */
double lemma1_period(const Constants *constants, const Cooperation *cooperation, bool driven, int n, const double *s,
                     const double *v, const double *a);
double exact_period(const Constants *constants, const Cooperation *cooperation, bool driven, int n, const double *s,
                    const double *v, const double *a);

#endif
