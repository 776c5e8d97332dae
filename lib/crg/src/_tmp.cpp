#include "crg/reference_line.h"
#include <cmath>
namespace crg{ Point2 node_position(const ReferenceLine& l,std::size_t i,double v){ std::size_t a=i==0?0:i-1,b=i+1<l.size()?i+1:i; double dx=l.x_m[b]-l.x_m[a],dy=l.y_m[b]-l.y_m[a],n=std::hypot(dx,dy); return {l.x_m[i]-v*dy/n,l.y_m[i]+v*dx/n};} }
