#include "shim.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Layouts that this file, or the library behind it, relies on. Sizes of hits are not asserted: they depend on a build
 * option (RTC_GEOMETRY_INSTANCE_ARRAY), which is why hits are only ever handed over with room behind them. */
#define OFFSET_IS(type, member, bytes) \
    _Static_assert(offsetof(struct type, member) == (bytes), #type "." #member " has moved")
_Static_assert(RTC_VERSION_MAJOR == AMBAKE_EMBREE_MAJOR, "these headers are of another major");
_Static_assert(RTC_VERSION >= 31300, "Embree 3.13 or newer is needed");
_Static_assert(RTC_MAX_INSTANCE_LEVEL_COUNT >= 1, "Embree was built without instances");
_Static_assert(RTC_INVALID_GEOMETRY_ID == AMBAKE_NO_INSTANCE, "the invalid id has changed");
_Static_assert(sizeof(int) == 4 && sizeof(float) == 4, "valid masks and rays are 32 bits a lane");
_Static_assert(sizeof(struct RTCRay) == 48 && _Alignof(struct RTCRay) == 16, "RTCRay has changed");
_Static_assert(sizeof(struct RTCRay8) == 384 && _Alignof(struct RTCRay8) == 32, "RTCRay8 has changed");
_Static_assert(sizeof(struct RTCRay16) == 768 && _Alignof(struct RTCRay16) == 64, "RTCRay16 has changed");
_Static_assert(sizeof(struct ambake_ray) == 32, "ambake_ray is padded");
_Static_assert(sizeof(struct ambake_packet8) == 256, "ambake_packet8 is padded");
_Static_assert(sizeof(struct ambake_packet16) == 512, "ambake_packet16 is padded");
OFFSET_IS(RTCRay, id, 40);
OFFSET_IS(RTCRay4, id, 10 * 16);
OFFSET_IS(RTCRay8, id, 10 * 32);
OFFSET_IS(RTCRay16, id, 10 * 64);
OFFSET_IS(RTCRayHit, hit, 48);
OFFSET_IS(RTCHit, u, 12);
OFFSET_IS(RTCHit, v, 16);
OFFSET_IS(RTCHit, primID, 20);
OFFSET_IS(RTCHit4, u, 3 * 16);
OFFSET_IS(RTCHit4, primID, 5 * 16);
OFFSET_IS(RTCHit8, u, 3 * 32);
OFFSET_IS(RTCHit8, primID, 5 * 32);
OFFSET_IS(RTCHit16, u, 3 * 64);
OFFSET_IS(RTCHit16, primID, 5 * 64);
OFFSET_IS(RTCFilterFunctionNArguments, N, 40);

RTCDevice ambake_new_device(const char *config, int *error, int *version)
{
    *version = 0;
    RTCDevice device = rtcNewDevice(config);
    if (!device) {
        *error = (int)rtcGetDeviceError(NULL);
        if (*error == RTC_ERROR_NONE)
            *error = RTC_ERROR_UNKNOWN;
        return NULL;
    }
    *version = (int)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION);
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_MAJOR) != RTC_VERSION_MAJOR) {
        *error = AMBAKE_ERROR_VERSION;
        rtcReleaseDevice(device);
        return NULL;
    }
    *error = RTC_ERROR_NONE;
    return device;
}

int ambake_take_error(RTCDevice device)
{
    return (int)rtcGetDeviceError(device);
}

int64_t ambake_property(RTCDevice device, int property)
{
    return (int64_t)rtcGetDeviceProperty(device, (enum RTCDeviceProperty)property);
}

/* Embree calls this for one lane (single rays) or several. RTCRayN and RTCHitN are structures of arrays of N: the
 * asserts above pin row 10 of the one, and rows 3, 4 and 5 of the other. Lanes whose valid is not -1 are not ours. */
static void filter_lanes(const struct RTCFilterFunctionNArguments *arguments)
{
    const struct ambake_filter *filter = arguments->geometryUserPtr;
    const unsigned n = arguments->N;
    const char *hit = (const char *)arguments->hit;
    for (unsigned i = 0; i < n; i++) {
        if (arguments->valid[i] != -1)
            continue;
        float u, v;
        uint32_t primitive, ray;
        memcpy(&ray, (const char *)arguments->ray + 4 * (10 * n + i), 4);
        memcpy(&u, hit + 4 * (3 * n + i), 4);
        memcpy(&v, hit + 4 * (4 * n + i), 4);
        memcpy(&primitive, hit + 4 * (5 * n + i), 4);
        if (!filter->keep(filter->closure, primitive, u, v, ray))
            arguments->valid[i] = 0;
    }
}

void ambake_set_filter(RTCGeometry geometry, const struct ambake_filter *filter)
{
    rtcSetGeometryUserData(geometry, (void *)filter);
    rtcSetGeometryIntersectFilterFunction(geometry, filter_lanes);
    rtcSetGeometryOccludedFilterFunction(geometry, filter_lanes);
}

void ambake_bounds(RTCScene scene, float bounds[6])
{
    struct RTCBounds b;
    rtcGetSceneBounds(scene, &b);
    bounds[0] = b.lower_x;
    bounds[1] = b.lower_y;
    bounds[2] = b.lower_z;
    bounds[3] = b.upper_x;
    bounds[4] = b.upper_y;
    bounds[5] = b.upper_z;
}

/* The same call in both majors: flags travel in a context (3) or in arguments (4), and the order differs. */
#if RTC_VERSION_MAJOR == 4
#define OCCLUDED_STATE(query)                                                        \
    struct RTCOccludedArguments state;                                               \
    rtcInitOccludedArguments(&state);                                                \
    if ((query) & AMBAKE_QUERY_COHERENT)                                             \
        state.flags = RTC_RAY_QUERY_FLAG_COHERENT
#define INTERSECT_STATE()                \
    struct RTCIntersectArguments state;  \
    rtcInitIntersectArguments(&state)
#define TRACE1(call, scene, ray) call(scene, ray, &state)
#define TRACE(call, valid, scene, ray) call(valid, scene, ray, &state)
#else
#define OCCLUDED_STATE(query)                                                        \
    /* Coherent packets of 16 can hang Debian's 3.13.5 on AVX-512: 3 never gets the flag. */ \
    struct RTCIntersectContext state;                                                \
    rtcInitIntersectContext(&state);                                                 \
    (void)(query)
#define INTERSECT_STATE() OCCLUDED_STATE(0)
#define TRACE1(call, scene, ray) call(scene, &state, ray)
#define TRACE(call, valid, scene, ray) call(valid, scene, &state, ray)
#endif

/* Our interval is open at t_min; a negative t_min means 0. Default triangles are open at tnear too; robust ones are
 * closed, so they get the next float up (at least FLT_MIN, so that nothing depends on how denormals are treated). */
static inline float near_end(float t_min, int robust)
{
    float near = t_min > 0.0f ? t_min : 0.0f;
    if (robust) {
        uint32_t bits;
        memcpy(&bits, &near, 4);
        bits += 1;
        memcpy(&near, &bits, 4);
        near = near > FLT_MIN ? near : FLT_MIN;
    }
    return near;
}

/* Ray::id of crates/embree/src/ray.rs says the same. */
static inline uint32_t mixed(uint32_t hash, float x)
{
    uint32_t bits;
    memcpy(&bits, &x, 4);
    hash = (hash ^ bits) * 0x9e3779b1u;
    return hash ^ (hash >> 15);
}

static inline uint32_t ray_id(float ox, float oy, float oz, float dx, float dy, float dz)
{
    return mixed(mixed(mixed(mixed(mixed(mixed(0, ox), oy), oz), dx), dy), dz);
}

/* False for an empty interval and for a NaN end: such a ray meets nothing and is not traced. */
static inline int is_open(float t_min, float t_max)
{
    return t_max > (t_min > 0.0f ? t_min : 0.0f);
}

/* False where the magnitude is not below reach, or is a NaN. */
static inline int is_within(float x, float reach)
{
    return (x < reach) & (x > -reach);
}

static inline int is_traceable(const struct ambake_ray *ray, float reach)
{
    int all = is_open(ray->t_min, ray->t_max);
    for (int axis = 0; axis < 3; axis++)
        all &= is_within(ray->origin[axis], reach) & is_within(ray->direction[axis], reach);
    return all;
}

static inline void fill_ray(struct RTCRay *out, const struct ambake_ray *ray, uint32_t query)
{
    out->org_x = ray->origin[0];
    out->org_y = ray->origin[1];
    out->org_z = ray->origin[2];
    out->tnear = near_end(ray->t_min, (query & AMBAKE_QUERY_ROBUST) != 0);
    out->dir_x = ray->direction[0];
    out->dir_y = ray->direction[1];
    out->dir_z = ray->direction[2];
    out->time = 0.0f;
    out->tfar = ray->t_max;
    out->mask = ~0u;
    out->id = 0;
    if (query & AMBAKE_QUERY_TELL_RAYS)
        out->id = ray_id(out->org_x, out->org_y, out->org_z, out->dir_x, out->dir_y, out->dir_z);
    out->flags = 0;
}

int ambake_occluded1(RTCScene scene, const struct ambake_ray *ray, uint32_t query, float reach)
{
    if (!is_traceable(ray, reach))
        return 0;
    OCCLUDED_STATE(query);
    struct RTCRay r;
    fill_ray(&r, ray, query);
    TRACE1(rtcOccluded1, scene, &r);
    return r.tfar < 0.0f;
}

/* The valid mask is as aligned as the packet: vector loads read it. A hit sets tfar to -inf; an active lane starts
 * with tfar > 0, so its sign tells. A lane that is off holds a harmless ray: kernels that split a packet look at it.
 * A packet with every lane off is not traced: some kernels never return from it. The loops over lanes are compiled for
 * each vector width, and the loader picks one. */
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define EVERY_WIDTH __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define EVERY_WIDTH
#endif
#define DEFINE_OCCLUDED(N)                                                                                       \
    EVERY_WIDTH void ambake_occluded##N(RTCScene scene, const struct ambake_packet##N *packets, const uint32_t *active,      \
                            uint32_t *blocked, size_t count, uint32_t query, float reach)                        \
    {                                                                                                            \
        const int robust = (query & AMBAKE_QUERY_ROBUST) != 0;                                                   \
        const int tell = (query & AMBAKE_QUERY_TELL_RAYS) != 0;                                                  \
        _Alignas(64) int valid[N];                                                                               \
        struct RTCRay##N r;                                                                                      \
        OCCLUDED_STATE(query);                                                                                   \
        for (size_t p = 0; p < count; p++) {                                                                     \
            const struct ambake_packet##N *in = &packets[p];                                                     \
            const uint32_t lanes = active[p];                                                                    \
            int any = 0;                                                                                         \
            for (int i = 0; i < N; i++) {                                                                        \
                int on = (int)(lanes >> i) & is_open(in->t_min[i], in->t_max[i]);                                \
                for (int axis = 0; axis < 3; axis++)                                                             \
                    on &= is_within(in->origin[axis][i], reach) & is_within(in->direction[axis][i], reach);      \
                valid[i] = -on;                                                                                  \
                any |= on;                                                                                       \
                r.org_x[i] = on ? in->origin[0][i] : 0.0f;                                                       \
                r.org_y[i] = on ? in->origin[1][i] : 0.0f;                                                       \
                r.org_z[i] = on ? in->origin[2][i] : 0.0f;                                                       \
                r.dir_x[i] = on ? in->direction[0][i] : 1.0f;                                                    \
                r.dir_y[i] = on ? in->direction[1][i] : 1.0f;                                                    \
                r.dir_z[i] = on ? in->direction[2][i] : 1.0f;                                                    \
                r.tnear[i] = on ? near_end(in->t_min[i], robust) : 0.0f;                                         \
                r.tfar[i] = on ? in->t_max[i] : -INFINITY;                                                       \
                r.time[i] = 0.0f;                                                                                \
                r.mask[i] = ~0u;                                                                                 \
                r.id[i] = 0;                                                                                     \
                r.flags[i] = 0;                                                                                  \
            }                                                                                                    \
            for (int i = 0; tell && i < N; i++)                                                                  \
                r.id[i] = ray_id(r.org_x[i], r.org_y[i], r.org_z[i], r.dir_x[i], r.dir_y[i], r.dir_z[i]);        \
            if (any)                                                                                             \
                TRACE(rtcOccluded##N, valid, scene, &r);                                                         \
            uint32_t bits = 0;                                                                                   \
            for (int i = 0; i < N; i++)                                                                          \
                bits |= (uint32_t)(valid[i] & (r.tfar[i] < 0.0f)) << i;                                          \
            blocked[p] = bits;                                                                                   \
        }                                                                                                        \
    }
DEFINE_OCCLUDED(8)
DEFINE_OCCLUDED(16)

/* The loop that nothing beats, to measure others against: every packet is copied, since a hit overwrites it, traced and
 * counted. Nothing is checked: active lanes must hold traceable rays with t_min 0, other lanes are left off. */
EVERY_WIDTH uint64_t ambake_bare16(RTCScene scene, const struct ambake_packet16 *packets, const uint32_t *active,
                                   size_t count, uint32_t query)
{
    const float near = near_end(0.0f, (query & AMBAKE_QUERY_ROBUST) != 0);
    _Alignas(64) int valid[16];
    struct RTCRay16 r;
    OCCLUDED_STATE(query);
    uint64_t blocked = 0;
    for (int i = 0; i < 16; i++) {
        r.tnear[i] = near;
        r.time[i] = 0.0f;
        r.mask[i] = ~0u;
        r.id[i] = 0;
        r.flags[i] = 0;
    }
    for (size_t p = 0; p < count; p++) {
        const struct ambake_packet16 *in = &packets[p];
        for (int i = 0; i < 16; i++)
            valid[i] = -(int)(active[p] >> i & 1);
        memcpy(r.org_x, in->origin[0], 64);
        memcpy(r.org_y, in->origin[1], 64);
        memcpy(r.org_z, in->origin[2], 64);
        memcpy(r.dir_x, in->direction[0], 64);
        memcpy(r.dir_y, in->direction[1], 64);
        memcpy(r.dir_z, in->direction[2], 64);
        memcpy(r.tfar, in->t_max, 64);
        TRACE(rtcOccluded16, valid, scene, &r);
        for (int i = 0; i < 16; i++)
            blocked += (uint64_t)(valid[i] & (r.tfar[i] < 0.0f));
    }
    return blocked;
}

int ambake_closest(RTCScene scene, const struct ambake_ray *ray, uint32_t query, float reach, uint32_t id,
                   struct ambake_hit *hit)
{
    if (!is_traceable(ray, reach))
        return 0;
    INTERSECT_STATE();
    /* RTCHit has grown by 16 bytes within major 4. The room keeps a library that is newer than the headers, or built
     * with other options, from writing past the end. */
    union {
        struct RTCRayHit ray_hit;
        unsigned char room[sizeof(struct RTCRayHit) + 128];
    } query_state;
    struct RTCRayHit *r = &query_state.ray_hit;
    fill_ray(&r->ray, ray, query & ~(uint32_t)AMBAKE_QUERY_TELL_RAYS);
    r->ray.id = id;
    r->hit.geomID = RTC_INVALID_GEOMETRY_ID;
    r->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    TRACE1(rtcIntersect1, scene, r);
    if (r->hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return 0;
    hit->t = r->ray.tfar;
    hit->u = r->hit.u;
    hit->v = r->hit.v;
    hit->normal[0] = r->hit.Ng_x;
    hit->normal[1] = r->hit.Ng_y;
    hit->normal[2] = r->hit.Ng_z;
    hit->primitive = r->hit.primID;
    hit->geometry = r->hit.geomID;
    hit->instance = r->hit.instID[0];
    return 1;
}
