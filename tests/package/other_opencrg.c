/* Another build of the interface, as far as examples/opencrg/drive.c needs it: flat, at 42 m. */
#include <crgBaseLib.h>

void crgMsgSetLevel(int level) { (void)level; }
int crgLoaderReadFile(const char* filename) { return filename != NULL; }
int crgCheck(int dataSetId) { return dataSetId; }
int crgDataSetModifierRemoveAll(int dataSetId) { return dataSetId; }
int crgDataSetModifierSetInt(int dataSetId, unsigned int optionId, int optionValue) {
  return dataSetId + (int)optionId + optionValue > 0;
}
void crgDataSetModifiersApply(int dataSetId) { (void)dataSetId; }
int crgDataSetGetURange(int dataSetId, double* uMin, double* uMax) {
  *uMin = 0.0;
  *uMax = 10.0;
  return dataSetId;
}
int crgDataSetGetVRange(int dataSetId, double* vMin, double* vMax) {
  *vMin = -1.0;
  *vMax = 1.0;
  return dataSetId;
}
int crgContactPointCreate(int dataSetId) { return dataSetId; }
int crgContactPointOptionSetInt(int cpId, unsigned int optionId, int optionValue) {
  return cpId + (int)optionId + optionValue > 0;
}
int crgEvaluv2xy(int cpId, double u, double v, double* x, double* y) {
  *x = u;
  *y = v;
  return cpId;
}
int crgEvalxy2uv(int cpId, double x, double y, double* u, double* v) {
  *u = x;
  *v = y;
  return cpId;
}
int crgEvalxy2z(int cpId, double x, double y, double* z) {
  *z = 42.0 + 0.0 * (x + y);
  return cpId;
}
int crgEvaluv2pk(int cpId, double u, double v, double* phi, double* curv) {
  *phi = *curv = 0.0 * (u + v);
  return cpId;
}
int crgContactPointDelete(int cpId) { return cpId; }
int crgDataSetRelease(int dataSetId) { return dataSetId; }
void crgMemRelease(void) {}
