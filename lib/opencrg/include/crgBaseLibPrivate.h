/* For programs that look into a data set, beside crgBaseLib.h: its channels as they are now. Only
 * what is named here is there; sizes and order of the members are those of this header, so that
 * programs are compiled with it. */
#ifndef KERBSTONE_CRG_BASE_LIB_PRIVATE_H
#define KERBSTONE_CRG_BASE_LIB_PRIVATE_H

#include "crgBaseLib.h"

/* Names as the interface has them.
 * NOLINTBEGIN(readability-identifier-naming, modernize-use-using) */
#ifdef __cplusplus
extern "C" {
#endif

/* What is known of a channel: its first and last value, the step (0 where there is none), what is
 * to be added to every value of `data`, and how many there are. */
typedef struct {
  double first, last, inc, mean;
  size_t size;
} CrgChannelInfoStruct;

typedef struct {
  CrgChannelInfoStruct info;
  double* data;
} CrgChannelStruct;

/* Heights of the grid, m; NaN in holes. */
typedef struct {
  CrgChannelInfoStruct info;
  float* data;
} CrgChannelFStruct;

/* u, v and the places of the reference line, m; its height (0 where the file has none), one value
 * for each u; of the grid one channel for each v, with a value for each u. */
typedef struct {
  CrgChannelStruct channelU, channelV, channelX, channelY, channelRefZ;
  CrgChannelFStruct* channelZ;
} CrgDataStruct;

/* A copy of the data set's channels, or NULL. The pointer stays until the set is released, and
 * crgDataSetModifiersApply() renews what it points to, data and all. Writing to it changes no
 * answer. */
CrgDataStruct* crgDataSetAccess(int dataSetId);

/* Searches keep no statistics here: the first does nothing, the second says so in a notice. */
void crgContactPointActivatePerfStat(int cpId);
void crgContactPointPrintPerfStat(int cpId);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(readability-identifier-naming, modernize-use-using) */

#endif
