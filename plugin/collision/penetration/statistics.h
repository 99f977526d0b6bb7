#ifndef PINCH_FINGERTIP_STATISTICS_H
#define PINCH_FINGERTIP_STATISTICS_H

#include <pinch/fingertip.h>

pinch_tip_stats *pinch_tip_counters(void);

#endif
