/* C interface of lib/crg: queries of an OpenCRG road. Opaque surfaces, no globals, no handles.
 *
 * A crg_surface is immutable and may be shared between threads; a crg_cursor belongs to one caller
 * (one per wheel), starts as {0} and only makes the next query faster. Queries allocate nothing and
 * never fail: where there is no road, z, gradient and normal are NaN and valid is 0; place, heading
 * and curvature are there all the same. Units: m, rad, s. */
#ifndef CRG_H
#define CRG_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The interface grows at the end of structs only; struct_size tells how much the caller knows. */
#define CRG_API_VERSION 1

/* NOLINTBEGIN(modernize-use-using,readability-identifier-naming) */
typedef struct crg_surface crg_surface;

typedef struct crg_cursor {
  size_t segment;
  double fraction, advance;
} crg_cursor;

typedef enum crg_modifiers {
  CRG_MODIFIERS_AS_IN_FILE = 0,
  CRG_MODIFIERS_NONE = 1,
  CRG_MODIFIERS_REFERENCE_DEFAULTS = 2 /* as the reference API where the file has no section */
} crg_modifiers;

typedef struct crg_open_options {
  size_t struct_size; /* sizeof(crg_open_options) */
  crg_modifiers modifiers;
  int smooth;                      /* 0 bilinear (the standard), 1 continuous slopes */
  int curvature_of_reference_line; /* 0 at the point's v, 1 at v = 0 */
  double friction;                 /* where there is no map; 0 counts as 1 */
  const char* friction_path;       /* file of the same shape, or NULL */
} crg_open_options;

typedef struct crg_sample {
  int valid;  /* there is road: z, gradient and normal are numbers */
  int inside; /* u, v lie on the grid */
  double u_m, v_m, x_m, y_m, z_m;
  double dzdx, dzdy;                   /* gradient in map axes */
  double normal_x, normal_y, normal_z; /* upward, length 1 */
  double heading_rad, curvature_1pm;
  double friction;
} crg_sample;
/* NOLINTEND(modernize-use-using,readability-identifier-naming) */

/* CRG_API_VERSION of the library. */
int crg_api_version(void);

/* Reads a file; options may be NULL. NULL on failure, with the reason in message (cut to
 * message_size, always terminated; message may be NULL). */
crg_surface* crg_open(const char* path, const crg_open_options* options, char* message,
                      size_t message_size);
void crg_close(crg_surface* surface); /* NULL is fine */

/* Range of the grid. */
void crg_range(const crg_surface* surface, double* u_begin_m, double* u_end_m, double* v_right_m,
               double* v_left_m);
int crg_is_closed(const crg_surface* surface);

/* Everything at a map point, or at (u, v); returns valid. */
int crg_at_xy(const crg_surface* surface, double x_m, double y_m, crg_cursor* cursor,
              crg_sample* sample);
int crg_at_uv(const crg_surface* surface, double u_m, double v_m, crg_sample* sample);

double crg_z_at_xy(const crg_surface* surface, double x_m, double y_m, crg_cursor* cursor);
double crg_z_at_uv(const crg_surface* surface, double u_m, double v_m);
void crg_xy_of_uv(const crg_surface* surface, double u_m, double v_m, double* x_m, double* y_m);
void crg_uv_of_xy(const crg_surface* surface, double x_m, double y_m, crg_cursor* cursor,
                  double* u_m, double* v_m);

/* along x across heights around (x, y), step_m apart, relative to the returned height;
 * dz_m has along * across places, across running fastest and to the left. */
double crg_strip(const crg_surface* surface, double x_m, double y_m, double heading_rad,
                 size_t along, size_t across, double step_m, float* dz_m, crg_cursor* cursor);

#ifdef __cplusplus
}
#endif
#endif
