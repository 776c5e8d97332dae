/* The interface of the OpenCRG C API, releases 1.2 and 2.0, for programs that already speak it.
 * Behind it stands lib/crg; docs/c-api.md says how to use it and where it differs.
 *
 * Units: metres, radians; u along the reference line, v to its left; headings counter-clockwise
 * from +x. Data set ids are greater than 0, contact point ids 0 or greater. Unless noted, a
 * function that returns int gives 1 for success and 0 for failure (unknown id, NULL, wrong kind of
 * option); results are then not to be used. No argument makes a function crash except pointers to
 * nowhere.
 *
 * Threads: any number of threads may evaluate at once, each with contact points of its own.
 * Loading, releasing, modifiers and creating or deleting contact points may run beside evaluations
 * of other data sets. Changing a data set while its own contact points evaluate is an error of the
 * caller. */
#ifndef KERBSTONE_CRG_BASE_LIB_H
#define KERBSTONE_CRG_BASE_LIB_H

#include <stdbool.h>
#include <stddef.h>

/* Levels of messages. */
#define dCrgMsgLevelNone 0
#define dCrgMsgLevelFatal 1
#define dCrgMsgLevelWarn 2
#define dCrgMsgLevelNotice 3
#define dCrgMsgLevelInfo 4
#define dCrgMsgLevelDebug 5

/* Options of a contact point: [i] whole number, [d] double. */
#define dCrgCpOptionBorderModeU 1    /* [i] dCrgBorderMode..., before the begin, behind the end */
#define dCrgCpOptionBorderModeV 2    /* [i] dCrgBorderMode..., beside the road */
#define dCrgCpOptionCurvMode 3       /* [i] dCrgCurv... */
#define dCrgCpOptionBorderOffsetU 5  /* [d] m, added beyond the ends */
#define dCrgCpOptionBorderOffsetV 6  /* [d] m, added beyond the sides */
#define dCrgCpOptionSmoothUBegin 7   /* [d] m, > 0, zone in which heights fade in */
#define dCrgCpOptionSmoothUEnd 8     /* [d] m, > 0, zone in which heights fade out */
#define dCrgCpOptionRefLineSearchU 9 /* [d] m, where the next search begins */
#define dCrgCpOptionRefLineSearchUFrac 10 /* [d] the same as a share of the length */
#define dCrgCpOptionRefLineClose 11       /* [d] m, kept; no influence on answers */
#define dCrgCpOptionRefLineFar 12         /* [d] m, kept; no influence on answers */
#define dCrgCpOptionRefLineContinue 13    /* [i] dCrgRefLine... */
#define dCrgCpOptionWarnMsgs 14           /* [i] kept */
#define dCrgCpOptionCheckEps 15           /* [d] relative accuracy that crgCheck() expects */
#define dCrgCpOptionCheckInc 16           /* [d] m, smallest increment */
#define dCrgCpOptionCheckTol 17           /* [d] m, tolerance of positions */
#define dCrgCpOptionWarnCurvLocal 18      /* [i, d] whether crgCheck() looks at local curvature */
#define dCrgCpOptionWarnCurvGlobal 19     /* [i, d] the same, of the whole line */

#define dCrgBorderModeNone 0   /* no height, the call fails */
#define dCrgBorderModeExZero 1 /* height 0 */
#define dCrgBorderModeExKeep 2 /* height of the edge */
#define dCrgBorderModeRepeat 3
#define dCrgBorderModeReflect 4

#define dCrgRefLineExtrapolate 0
#define dCrgRefLineCloseTrack 1

#define dCrgCurvLateral 0 /* of the line at v through the point */
#define dCrgCurvRefLine 1 /* of the reference line */

/* Modifiers of a data set. */
#define dCrgModScaleZ 21            /* [d] */
#define dCrgModScaleSlope 22        /* [d] */
#define dCrgModScaleBank 23         /* [d] */
#define dCrgModScaleLength 24       /* [d] */
#define dCrgModScaleWidth 25        /* [d] */
#define dCrgModScaleCurvature 26    /* [d] */
#define dCrgModGridNaNMode 27       /* [i] dCrgGridNaN... */
#define dCrgModGridNaNOffset 28     /* [d] m */
#define dCrgModRefPointV 29         /* [d] m; the point of the road that is placed ... */
#define dCrgModRefPointVFrac 30     /* [d] */
#define dCrgModRefPointVOffset 31   /* [d] m */
#define dCrgModRefPointU 32         /* [d] m */
#define dCrgModRefPointUFrac 33     /* [d] */
#define dCrgModRefPointUOffset 34   /* [d] m */
#define dCrgModRefPointX 35         /* [d] m; ... and where it comes to lie */
#define dCrgModRefPointY 36         /* [d] m */
#define dCrgModRefPointZ 37         /* [d] m */
#define dCrgModRefPointPhi 38       /* [d] rad */
#define dCrgModRefLineOffsetX 39    /* [d] m */
#define dCrgModRefLineOffsetY 40    /* [d] m */
#define dCrgModRefLineOffsetZ 41    /* [d] m */
#define dCrgModRefLineOffsetPhi 42  /* [d] rad */
#define dCrgModRefLineRotCenterX 43 /* [d] m */
#define dCrgModRefLineRotCenterY 44 /* [d] m */

#define dCrgSizeOptList 50

#define dCrgGridNaNKeep 0
#define dCrgGridNaNSetZero 1
#define dCrgGridNaNKeepLast 2

#define dCrgOrientFwd 0
#define dCrgOrientRev 1

/* Names as the interface has them. NOLINTBEGIN(readability-identifier-naming) */
#ifdef __cplusplus
extern "C" {
#endif

/* Data sets. crgLoaderReadFile() gives an id, or 0 and a message that says why; options and
 * modifiers of the file (or the defaults) are set, modifiers not yet applied. crgCheck() gives 1
 * for data that are consistent. Releasing also deletes the set's contact points. */
int crgLoaderReadFile(const char* filename);
void crgLoaderSuppressFileNotFoundFatalMsg(bool suppress);
int crgCheck(int dataSetId);
int crgDataSetRelease(int dataSetId);
void crgMemRelease(void); /* all data sets */
const char* crgGetReleaseInfo(void);
void crgDataPrintHeader(int dataSetId);
void crgDataPrintChannelInfo(int dataSetId);
void crgDataPrintRoadInfo(int dataSetId);
int crgDataSetGetURange(int dataSetId, double* uMin, double* uMax);
int crgDataSetGetVRange(int dataSetId, double* vMin, double* vMax);
/* vInc is 0.01 where sections are unevenly spaced and the file names no increment. */
int crgDataSetGetIncrements(int dataSetId, double* uInc, double* vInc);
/* Whether the two ends meet, and the u range of the closed line; 0, 0 where they do not. */
int crgDataSetGetUtilityDataClosedTrack(const int dataSetId, int* uIsClosed, double* uCloseMin,
                                        double* uCloseMax);

/* Modifiers act when applied, and are then removed; contact points follow. */
int crgDataSetModifierSetInt(int dataSetId, unsigned int optionId, int optionValue);
int crgDataSetModifierSetDouble(int dataSetId, unsigned int optionId, double optionValue);
int crgDataSetModifierGetInt(int dataSetId, unsigned int optionId, int* optionValue);
int crgDataSetModifierGetDouble(int dataSetId, unsigned int optionId, double* optionValue);
int crgDataSetModifierRemove(int dataSetId, unsigned int modId);
int crgDataSetModifierRemoveAll(int dataSetId);
void crgDataSetModifiersPrint(int dataSetId);
void crgDataSetModifiersApply(int dataSetId);
void crgDataSetModifierSetDefault(int dataSetId);
void crgDataSetOptionSetDefault(int dataSetId);

/* Where the road's axes lie in the world, m and rad: they turn by poff about the begin of the line,
 * then move. Begins with the file's REFERENCE_LINE_OFFSET_*, and follows modifiers that move the
 * road, so that its place in the world stays; setting it moves the road likewise. */
int crgDataSetGetGlobalOrigin(int dataSetId, double* xoff, double* yoff, double* zoff,
                              double* poff);
int crgDataSetSetGlobalOrigin(int dataSetId, double xoff, double yoff, double zoff, double poff);

/* Contact points. crgContactPointCreate() gives an id, or -1; the point begins with the options of
 * its data set. A dataSetId of -1 deletes all points of all data sets. */
int crgContactPointCreate(int dataSetId);
int crgContactPointDelete(int cpId);
void crgContactPointDeleteAll(int dataSetId);
int crgContactPointOptionSetInt(int cpId, unsigned int optionId, int optionValue);
int crgContactPointOptionSetDouble(int cpId, unsigned int optionId, double optionValue);
int crgContactPointOptionGetInt(int cpId, unsigned int optionId, int* optionValue);
int crgContactPointOptionGetDouble(int cpId, unsigned int optionId, double* optionValue);
int crgContactPointOptionRemove(int cpId, unsigned int optionId);
int crgContactPointOptionRemoveAll(int cpId);
void crgContactPointOptionsPrint(int cpId);
void crgContactPointSetDefaultOptions(int cpId);
/* Answers and speed do not depend on a history here; the size is taken and not used. */
int crgContactPointSetHistory(int cpId, int histSize);
void crgContactPointSetHistoryForAllPoints(int histSize);

/* Evaluation. z is NaN, with return value 1, on a hole of the grid; 0 comes back beyond a border of
 * mode none, and for coordinates that are not finite. */
int crgEvalxy2uv(int cpId, double x, double y, double* u, double* v);
int crgEvaluv2xy(int cpId, double u, double v, double* x, double* y);
int crgEvaluv2z(int cpId, double u, double v, double* z);
int crgEvalxy2z(int cpId, double x, double y, double* z);
int crgEvaluv2pk(int cpId, double u, double v, double* phi, double* curv);
int crgEvalxy2pk(int cpId, double x, double y, double* phi, double* curv);
/* From the road's axes to the world (east, north, height) and back. */
int crgEvalxyz2enh(int cpId, double x, double y, double z, double* e, double* n, double* h);
int crgEvalenh2xyz(int cpId, double e, double n, double h, double* x, double* y, double* z);

/* Messages up to the level (first: notice) go to stderr, or to the callback. The numbers of
 * warnings and of messages below them that go to stderr can be limited; -1: no limit. */
void crgMsgSetLevel(int level);
void crgMsgSetMaxWarnMsgs(int maxNo);
void crgMsgSetMaxLogMsgs(int maxNo);
int crgMsgIsPrintable(int level);
void crgMsgPrint(int level, const char* format, ...);
void crgMsgSetCallback(int (*func)(int level, char* message));

/* Memory: calloc, realloc and free, or the caller's. */
void* crgCalloc(size_t nmemb, size_t size);
void crgCallocSetCallback(void* (*func)(size_t nmemb, size_t size));
void* crgRealloc(void* ptr, size_t size);
void crgReallocSetCallback(void* (*func)(void* ptr, size_t size));
void crgFree(void* ptr);
void crgFreeSetCallback(void (*func)(void* ptr));

#ifdef __cplusplus
}
#endif
/* NOLINTEND(readability-identifier-naming) */

#endif
