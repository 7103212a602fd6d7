//! A placed probe as a list of numbers, so that it can be kept and comes back bit for bit.

use crate::estimate::PARTS;
use crate::gather::DISTANCE_EDGE;
use crate::{Placed, Probe, State};
use ambient::harmonics::count;
use glam::DVec3;

/// Numbers before those of the light.
const HEAD: usize = 6;

const TEXELS: usize = DISTANCE_EDGE * DISTANCE_EDGE;

const STATES: [State; 3] = [State::There, State::Moved, State::Invalid];

impl Placed {
    /// How many numbers one with harmonics of this order is.
    pub fn length(order: usize) -> usize {
        HEAD + 3 * (2 + PARTS) * count(order) + 2 * TEXELS
    }

    /// Everything about it but where it was asked for, as numbers.
    pub fn numbers(&self) -> Vec<f64> {
        let probe = &self.probe;
        let state = STATES.iter().position(|state| *state == self.state);
        let mut numbers = vec![state.unwrap_or_default() as f64, probe.rays.into()];
        numbers.extend(probe.place.to_array());
        numbers.push(probe.validity);
        for values in [&probe.light, &probe.std_err]
            .into_iter()
            .chain(&probe.parts)
        {
            numbers.extend(values.iter().flat_map(|value| value.to_array()));
        }
        numbers.extend(probe.distance.as_flattened().iter().map(|&v| f64::from(v)));
        numbers
    }

    /// The one that was asked for at a place, from its numbers; `None` where they are not of one of this order.
    pub fn of_numbers(numbers: &[f64], order: usize, asked: DVec3) -> Option<Self> {
        if numbers.len() != Self::length(order) {
            return None;
        }
        let (head, rest) = numbers.split_at(HEAD);
        let (light, distance) = rest.split_at(rest.len() - 2 * TEXELS);
        let values = light.as_chunks::<3>().0;
        let mut values = values.iter().map(|value| DVec3::from_array(*value));
        let mut next = || values.by_ref().take(count(order)).collect::<Vec<DVec3>>();
        let distance = distance.as_chunks::<2>().0.iter();
        Some(Self {
            asked,
            state: *STATES.get(head[0] as usize)?,
            probe: Probe {
                place: DVec3::new(head[2], head[3], head[4]),
                light: next(),
                std_err: next(),
                rays: head[1] as u32,
                parts: std::array::from_fn(|_| next()),
                validity: head[5],
                distance: distance.map(|pair| pair.map(|v| v as f32)).collect(),
                way_out: None,
            },
        })
    }
}
