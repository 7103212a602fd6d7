//! Rays, packets and hits: plain data that works without the library.

/// A ray and its interval: it meets what lies at `t_min < t <= t_max`, at `origin + t * direction`.
///
/// A negative `t_min` means 0. An empty interval, or a NaN in it, meets nothing. `origin` and `direction` are expected
/// finite and `direction` non-zero; other values meet anything or nothing but are not unsound.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Start, in world units.
    pub origin: [f32; 3],
    /// Direction; its length is the unit of `t`.
    pub direction: [f32; 3],
    /// Open lower end of the interval.
    pub t_min: f32,
    /// Closed upper end of the interval; infinity for no end.
    pub t_max: f32,
}

impl Ray {
    /// A hash of origin and direction, bit by bit: what a hit test knows of the ray that it decides for, on every
    /// machine.
    #[inline]
    pub fn id(&self) -> u32 {
        let numbers = self.origin.iter().chain(&self.direction);
        numbers.fold(0, |hash: u32, x| {
            let hash = (hash ^ x.to_bits()).wrapping_mul(0x9e37_79b1);
            hash ^ (hash >> 15)
        })
    }
}

/// Stands for a packet width in bounds: `Lanes<N>: PacketWidth` holds for N = 8 and N = 16.
#[derive(Debug, Clone, Copy)]
pub struct Lanes<const N: usize>;

/// A packet width that Embree traces: 8 or 16. Sealed.
pub trait PacketWidth: sealed::Sealed {}

impl PacketWidth for Lanes<8> {}
impl PacketWidth for Lanes<16> {}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Lanes<8> {}
    impl Sealed for super::Lanes<16> {}
}

/// `N` rays as a structure of arrays, so that an integrator fills lanes with vector code. Lane `i` is ray `i`; lane
/// masks are `u32` with bit `i` for lane `i`, and bits from `N` on are ignored.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayPacket<const N: usize>
where
    Lanes<N>: PacketWidth,
{
    /// Starts: x of all lanes, then y, then z.
    pub origin: [[f32; N]; 3],
    /// Directions: x of all lanes, then y, then z.
    pub direction: [[f32; N]; 3],
    /// Open lower ends.
    pub t_min: [f32; N],
    /// Closed upper ends.
    pub t_max: [f32; N],
}

impl<const N: usize> RayPacket<N>
where
    Lanes<N>: PacketWidth,
{
    /// The mask with every lane active.
    pub const ALL: u32 = u32::MAX >> (32 - N);

    /// A packet whose rays all have an empty interval: a lane that is never set meets nothing.
    pub const fn new() -> Self {
        Self {
            origin: [[0.0; N]; 3],
            direction: [[0.0; N], [0.0; N], [1.0; N]],
            t_min: [0.0; N],
            t_max: [0.0; N],
        }
    }

    /// Puts `ray` into `lane`.
    ///
    /// # Panics
    /// Where `lane >= N`.
    #[inline]
    pub fn set(&mut self, lane: usize, ray: &Ray) {
        for axis in 0..3 {
            self.origin[axis][lane] = ray.origin[axis];
            self.direction[axis][lane] = ray.direction[axis];
        }
        self.t_min[lane] = ray.t_min;
        self.t_max[lane] = ray.t_max;
    }

    /// The ray in `lane`.
    ///
    /// # Panics
    /// Where `lane >= N`.
    #[inline]
    pub fn get(&self, lane: usize) -> Ray {
        Ray {
            origin: self.origin.map(|row| row[lane]),
            direction: self.direction.map(|row| row[lane]),
            t_min: self.t_min[lane],
            t_max: self.t_max[lane],
        }
    }
}

impl<const N: usize> Default for RayPacket<N>
where
    Lanes<N>: PacketWidth,
{
    fn default() -> Self {
        Self::new()
    }
}

/// How alike the rays of a packet are: a hint for speed.
///
/// Rays of about unit direction that start within a scene get the same answer either way, but where they graze an edge
/// within rounding: Embree 4 walks a coherent packet by other arithmetic. Rays of arbitrary bits (directions near the
/// ends of the range of f32, or with components that underflow) may be answered otherwise, so nothing that must not
/// change with the hint may rest on such rays.
///
/// Embree 3 is never told: coherent packets of 16 can hang Debian's 3.13.5 on AVX-512. Nor is a scene with instances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coherence {
    /// Directions differ: each ray goes its own way.
    Incoherent,
    /// One direction, neighbouring origins. Twice as slow as `Incoherent` where that is not so.
    Coherent,
}

/// The closest thing a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Place on the ray, within `t_min < t <= t_max`.
    pub t: f32,
    /// Geometry id in the scene that holds the triangle: the instanced scene where `instance` is set.
    pub geometry: u32,
    /// Triangle's index in its mesh.
    pub primitive: u32,
    /// Geometry id of the instance in the traced scene; `None` where the triangle is the scene's own.
    pub instance: Option<u32>,
    /// Weights of the triangle's second and third corner; the first has the rest. Rounding may take them past 0..=1.
    pub barycentric: [f32; 2],
    /// Geometric normal, not of unit length, by the right-hand rule of the winding, in the geometry's own space.
    pub normal: [f32; 3],
    /// The ray arrives on the side the normal points to (seen in the geometry's own space, so a mirroring instance
    /// does not turn it over).
    pub front: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_and_get_agree_and_leave_other_lanes_alone() {
        let ray = |k: f32| Ray {
            origin: [k, k + 1.0, k + 2.0],
            direction: [-k, 1.0, k],
            t_min: k,
            t_max: 2.0 * k,
        };
        let mut packet = RayPacket::<16>::new();
        for lane in 0..16 {
            packet.set(lane, &ray(lane as f32));
        }
        for lane in 0..16 {
            assert_eq!(packet.get(lane), ray(lane as f32));
        }
    }

    #[test]
    fn packets_are_aligned_for_the_widest_vectors() {
        assert_eq!(align_of::<RayPacket<8>>(), 64);
        assert_eq!(align_of::<RayPacket<16>>(), 64);
        assert_eq!(size_of::<RayPacket<8>>(), 8 * 32);
        assert_eq!(size_of::<RayPacket<16>>(), 16 * 32);
        assert_eq!(RayPacket::<8>::ALL, 0xff);
        assert_eq!(RayPacket::<16>::ALL, 0xffff);
    }
}
