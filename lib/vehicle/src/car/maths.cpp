#include "vehicle/maths.h"

namespace vehicle::maths {

double sin(double x) { return any_waves(x).sine; }
double cos(double x) { return any_waves(x).cosine; }
Waves<double> waves(double x) { return any_waves(x); }
double atan(double x) { return arc_tangent(x); }
double exp(double x) { return exponential(x); }
double log(double x) { return logarithm(x); }
double tanh(double x) { return hyperbolic_tangent(x); }

}  // namespace vehicle::maths
