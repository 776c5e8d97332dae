#include "vehicle/maths.h"

namespace vehicle::maths {

double sin(double x) { return sine(x); }
double cos(double x) { return cosine(x); }
Waves<double> waves(double x) { return both_waves(x); }
double atan(double x) { return arc_tangent(x); }
double exp(double x) { return exponential(x); }
double log(double x) { return logarithm(x); }
double tanh(double x) { return hyperbolic_tangent(x); }

}  // namespace vehicle::maths
