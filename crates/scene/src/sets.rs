//! Numbers that are joined pair by pair into sets, such as triangles that share edges into surfaces.

/// Disjoint sets of the numbers from 0 (R. E. Tarjan, "Efficiency of a Good But Not Linear Set Union Algorithm", 1975).
/// The least number of a set stands for it, so that the order of joins does not show.
///
/// ```
/// let mut sets = ambake_scene::Sets::new(4);
/// sets.join(3, 1);
/// assert_eq!([0, 1, 2, 3].map(|number| sets.root(number)), [0, 1, 2, 1]);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Sets(Vec<u32>);

impl Sets {
    /// So many numbers, each alone. A scene has fewer triangles than numbers of 32 bits, which validation sees to.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// Adds the next number, alone.
    pub fn push(&mut self) {
        self.0.push(self.0.len() as u32);
    }

    /// The least number of the set of a number.
    ///
    /// # Panics
    /// The number is not below their count.
    pub fn root(&mut self, mut number: u32) -> u32 {
        let parents = &mut self.0;
        while parents[number as usize] != number {
            parents[number as usize] = parents[parents[number as usize] as usize];
            number = parents[number as usize];
        }
        number
    }

    /// Makes one set of those of two numbers.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
