/* One set of entry points over Embree 3.13 and Embree 4.
 *
 * Compiled against the installed headers, so the C compiler checks names, argument orders and layouts. Everything whose
 * signature or meaning differs between the majors goes through a function of this file; what is equal in both
 * (geometry and scene set-up) is called directly. */
#ifndef AMBAKE_SHIM_H
#define AMBAKE_SHIM_H

#include <stddef.h>
#include <stdint.h>

#if AMBAKE_EMBREE_MAJOR == 4
#include <embree4/rtcore.h>
#elif AMBAKE_EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
#else
#error "AMBAKE_EMBREE_MAJOR must be 3 or 4"
#endif

/* A ray: open at t_min, closed at t_max. */
struct ambake_ray {
    float origin[3];
    float direction[3];
    float t_min;
    float t_max;
};

/* Eight and sixteen rays, lane by lane in each array. */
struct __attribute__((aligned(64))) ambake_packet8 {
    float origin[3][8];
    float direction[3][8];
    float t_min[8];
    float t_max[8];
};

struct __attribute__((aligned(64))) ambake_packet16 {
    float origin[3][16];
    float direction[3][16];
    float t_min[16];
    float t_max[16];
};

/* A closest hit; instance is AMBAKE_NO_INSTANCE where the hit is not inside an instance. */
#define AMBAKE_NO_INSTANCE 0xffffffffu
struct ambake_hit {
    float t;
    float u, v;
    float normal[3];
    uint32_t primitive;
    uint32_t geometry;
    uint32_t instance;
};

/* What a filter geometry's user pointer points to. ray is a hash of the ray's origin and direction as they were handed
 * over, also inside an instance; 0 where the query does not say AMBAKE_QUERY_TELL_RAYS. keep must not unwind and must be callable from any thread. */
struct ambake_filter {
    bool (*keep)(const void *closure, uint32_t primitive, float u, float v, uint32_t ray);
    const void *closure;
};

/* Flags of a query. ROBUST must be set exactly where the scene was built with RTC_SCENE_FLAG_ROBUST. */
enum ambake_query { AMBAKE_QUERY_COHERENT = 1, AMBAKE_QUERY_ROBUST = 2, AMBAKE_QUERY_TELL_RAYS = 4 };

/* In all queries: a ray meets nothing where a coordinate of its origin or direction is not below reach in magnitude
 * (or is a NaN). Debian's Embree 3 is built with its assertions and aborts on rays past 1.844e18, also in the space of
 * an instance; reach is what keeps every ray of the scene below that. */

/* A device, or null with *error set to an RTCError, or to AMBAKE_ERROR_VERSION where the loaded library has another
 * major than the headers; *version is then the library's RTC_DEVICE_PROPERTY_VERSION. */
enum ambake_error { AMBAKE_ERROR_VERSION = -1 };
RTCDevice ambake_new_device(const char *config, int *error, int *version);

/* The thread's first error since the last call, as a plain int. */
int ambake_take_error(RTCDevice device);

/* A device property, or 0 where this major has none. */
int64_t ambake_property(RTCDevice device, int property);

/* Makes a hit on this triangle geometry count only where the filter keeps it. */
void ambake_set_filter(RTCGeometry geometry, const struct ambake_filter *filter);

/* Bounds of a committed scene: three lower, three upper coordinates. */
void ambake_bounds(RTCScene scene, float bounds[6]);

/* 1 where something lies in the ray's interval, else 0. */
int ambake_occluded1(RTCScene scene, const struct ambake_ray *ray, uint32_t query, float reach);

/* For each of count packets: bit i of blocked[p] is set where bit i of active[p] is set and ray i meets something. */
void ambake_occluded8(RTCScene scene, const struct ambake_packet8 *packets, const uint32_t *active, uint32_t *blocked,
                      size_t count, uint32_t query, float reach);
void ambake_occluded16(RTCScene scene, const struct ambake_packet16 *packets, const uint32_t *active,
                       uint32_t *blocked, size_t count, uint32_t query, float reach);
uint64_t ambake_bare16(RTCScene scene, const struct ambake_packet16 *packets, const uint32_t *active, size_t count,
                       uint32_t query);

/* 1 and *hit filled where something lies in the ray's interval, else 0. Filters are told id, whatever query says. */
int ambake_closest(RTCScene scene, const struct ambake_ray *ray, uint32_t query, float reach, uint32_t id,
                   struct ambake_hit *hit);

#endif
