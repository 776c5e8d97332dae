/* The calls of a vehicle simulator to the OpenCRG C API: a road, four wheels, a few metres of
 * driving. Links against any library of that interface. Usage: drive ROAD.crg */
#include <crgBaseLib.h>
#include <stdio.h>

#define WHEELS 4

int main(int argc, char** argv) {
  const double along_m[WHEELS] = {1.4, 1.4, -1.4, -1.4}, across_m[WHEELS] = {0.8, -0.8, 0.8, -0.8};
  double u_min, u_max, v_min, v_max;
  int wheel[WHEELS];

  crgMsgSetLevel(dCrgMsgLevelFatal);
  const int road = crgLoaderReadFile(argc > 1 ? argv[1] : "road.crg");
  if (road <= 0) return fprintf(stderr, "the road was not read\n"), 1;
  if (!crgCheck(road)) return fprintf(stderr, "the road is not consistent\n"), 1;

  /* Where missing heights are filled and nothing moves: only this modifier. */
  crgDataSetModifierRemoveAll(road);
  crgDataSetModifierSetInt(road, dCrgModGridNaNMode, dCrgGridNaNKeepLast);
  crgDataSetModifiersApply(road);
  crgDataSetGetURange(road, &u_min, &u_max);
  crgDataSetGetVRange(road, &v_min, &v_max);
  printf("u %.2f to %.2f m, v %.2f to %.2f m\n", u_min, u_max, v_min, v_max);

  for (int i = 0; i < WHEELS; ++i) {
    wheel[i] = crgContactPointCreate(road);
    crgContactPointOptionSetInt(wheel[i], dCrgCpOptionBorderModeU, dCrgBorderModeExKeep);
    crgContactPointOptionSetInt(wheel[i], dCrgCpOptionBorderModeV, dCrgBorderModeExKeep);
  }
  for (double u_m = u_min + 2.0; u_m < u_max - 2.0; u_m += 1.0) {
    printf("u %.1f z", u_m);
    for (int i = 0; i < WHEELS; ++i) {
      double x_m, y_m, z_m, on_u_m, on_v_m;
      crgEvaluv2xy(wheel[i], u_m + along_m[i], across_m[i], &x_m, &y_m);
      if (!crgEvalxy2z(wheel[i], x_m, y_m, &z_m)) return fprintf(stderr, "no road\n"), 1;
      crgEvalxy2uv(wheel[i], x_m, y_m, &on_u_m, &on_v_m);
      printf(" %.4f", z_m);
    }
    double heading_rad, curvature_1pm;
    crgEvaluv2pk(wheel[0], u_m, 0.0, &heading_rad, &curvature_1pm);
    printf(" heading %.4f curvature %.4f\n", heading_rad, curvature_1pm);
  }
  for (int i = 0; i < WHEELS; ++i) crgContactPointDelete(wheel[i]);
  crgDataSetRelease(road);
  crgMemRelease();
  return 0;
}
