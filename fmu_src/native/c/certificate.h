/* What certifies a sampling period. */
#ifndef PSP_CERTIFICATE_H
#define PSP_CERTIFICATE_H

#include "cooperation.h"

enum { CERTIFICATE_LEMMA1 = 1, CERTIFICATE_EXACT = 2 };

/* For n vehicles under accelerations that are about to be held: how long speeds stay inside their bounds; T_max of Lemma 1;
 * how long gaps stay open.  T_exact is the less of the first and the last.  Lengths are those of the cooperation, all L where
 * it is NULL; the own speed of a first vehicle that drives itself, `driven`, sets no bound. */
double speed_period(const Constants *constants, bool driven, int n, const double *v, const double *a);
double lemma1_period(const Constants *constants, const Cooperation *cooperation, bool driven, int n, const double *s,
                     const double *v, const double *a);
double contact_period(const Constants *constants, const Cooperation *cooperation, int n, const double *s, const double *v,
                      const double *a);

#endif
