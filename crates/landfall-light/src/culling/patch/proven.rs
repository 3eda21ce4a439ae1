//! Grids of lamps with a proven error.
//!
//! A patch has a grid for each order, on the same rectangle: lamps further away need fewer nodes.

use super::{Above, Item, Near, Patches};
use crate::culling::lamps::Lamps;
use crate::culling::plane::Plane;
use crate::culling::select::{Select, Selected};
use crate::culling::smooth::{ORDERS, Order, Rectangle, Shading};
use crate::culling::{Job, STEP};
use crate::shading_f32::SpecularTerm;

/// Lights for a grid: its nodes a side, their places, and the sum of their errors.
pub(super) struct Taken {
    pub side: u32,
    pub places: Vec<u32>,
    pub spent: f64,
}

/// The nodes a side of the grids of a patch.
pub(super) const SIDES: [u32; ORDERS] = [2, 4, 6, 8];

/// The fragments a node, from which a grid is worth its nodes.
const FEWEST: usize = 2;

/// The fragments a node, beyond which a grid of more nodes costs no more worth mentioning.
const MOST: usize = 300;

/// The orders, the lowest of a patch, that are tried for groups of lamps: others are better chosen for
/// each.
const FOR_GROUPS: usize = 2;

/// Above the relative rounding of a sum of errors.
const ROUNDING: f64 = 1e-4;

/// The bits of a count of lamps of an order, in a register with those of all orders.
const BITS: u32 = 64 / (ORDERS as u32 + 1);
const MASK: u64 = (1 << BITS) - 1;

impl Patches<'_> {
    /// Moves lamps into a grid as long as their errors stay within this patch's share, with those that
    /// are `far` already; returns the innermost grid, and the lights left if they are others.
    pub(super) fn take_proven(
        &mut self,
        items: &[Item],
        plane: &Plane,
        rectangle: &Rectangle,
        (near, far): (&Near, Vec<Taken>),
        above: Above,
    ) -> (Above, Option<Near>) {
        let others = (!near.others.is_empty()).then(|| self.others(items, near).0);
        let left = self.interpolate.within.unwrap_or(0.0) * STEP - above.spent;
        let share = self.share(items.len(), left) - far.iter().map(|far| far.spent).sum::<f64>();
        let found = self.provably_far(items, rectangle, (&near.lamps, 1), (share, above));
        let (more, lamps) = found.unzip();
        let mut taken = more.unwrap_or_default();
        // Lamps of groups go into the grid of their order.
        for far in far {
            match taken.iter_mut().find(|taken| taken.side == far.side) {
                Some(taken) => {
                    taken.places.extend(far.places);
                    taken.spent += far.spent;
                }
                None => taken.push(far),
            }
        }
        let mut here = above;
        for Taken { side, places, spent } in taken {
            here.grid = self.grid(items, plane, rectangle, (side, places), here.grid);
            here.spent += spent;
        }
        let kept = (lamps.is_some() || others.is_some()).then(|| Near {
            lamps: lamps.unwrap_or_else(|| near.lamps.clone()),
            others: others.unwrap_or_else(|| near.others.clone()),
        });
        (here, kept)
    }

    /// Returns the orders of the grids of so many fragments, the lowest first.
    fn orders(&self, fragments: usize) -> Vec<Order> {
        let most = self.interpolate.nodes;
        let orders = self.orders.iter().filter(|order| order.side() <= most);
        let highest = orders.clone().next_back().map(Order::side);
        let fits = |order: &&Order| {
            let many = order.nodes() * MOST >= fragments || Some(order.side()) == highest;
            order.nodes() * FEWEST <= fragments && many
        };
        orders.filter(fits).copied().collect()
    }

    /// Divides lamps, or groups of `each`, into those whose errors together fit into `share`, by order,
    /// and the others. `None` if taking them does not pay.
    pub(super) fn provably_far(
        &mut self,
        items: &[Item],
        rectangle: &Rectangle,
        (lamps, each): (&Lamps, usize),
        (share, above): (f64, Above),
    ) -> Option<(Vec<Taken>, Lamps)> {
        let Job { upload, model, frame, .. } = *self.job;
        let mut orders = self.orders(items.len());
        if each > 1 {
            orders.truncate(FOR_GROUPS);
        }
        let highest = orders.last()?.side();
        let known = rectangle.diameter() > 0.0 && share > 0.0;
        let inner = above.grid.is_some();
        if !(known && self.is_worth(each * lamps.len(), items.len(), highest, inner)) {
            return None;
        }
        let first = &frame.fragments[items[0].number as usize];
        let given = upload.materials[first.material as usize].shininess;
        let shading = Shading {
            shininess: model.shininess.map_or(given, f64::from),
            everywhere: model.specular == SpecularTerm::Everywhere,
        };
        self.tests += lamps.len() as u64;
        let found = self.errors.find(&orders, lamps, rectangle, &shading, share as f32);
        if !(found && self.select(&orders, each, items.len(), (share, inner))) {
            return None;
        }
        let (taken, kept) = by_order(&orders, lamps, &self.selected);
        // A patch that is not divided tests no lamps again.
        let kept = match each == 1 && items.len() <= self.fewest() {
            true => lamps.some_places(&kept),
            false => lamps.some(&kept),
        };
        Some((taken, kept))
    }

    /// Selects lamps, or groups of `each`, whose errors were found, of the orders that pay; returns
    /// whether one does.
    fn select(
        &mut self,
        orders: &[Order],
        each: usize,
        fragments: usize,
        (share, inner): (f64, bool),
    ) -> bool {
        let nodes = |order: usize| orders[order].nodes() as f64;
        let mut used: Vec<usize> = (0..orders.len()).collect();
        while !used.is_empty() {
            let mut saved = [0.0; ORDERS];
            for (at, order) in used.iter().enumerate() {
                // Beside the next order, or a grid on each quarter of the patch.
                let quarters = (fragments as f64).min(4.0 * nodes(*order));
                let beside = used.get(at + 1).map_or(quarters, |next| nodes(*next));
                saved[*order] = (beside - nodes(*order)) as f32;
            }
            let errors = &self.errors.of[..orders.len()];
            let share = (share * (1.0 - 3.0 * ROUNDING)) as f32;
            self.selected.find(&Select { errors, saved, share });
            match self.wasted(orders, &used, each, (fragments, inner)) {
                // Its lamps go into the next.
                Some(at) => drop(used.remove(at)),
                None => return self.selected.counts.iter().any(|count| *count > 0),
            }
        }
        false
    }

    /// Returns the first of the orders used whose lamps do not pay for a grid.
    fn wasted(
        &self,
        orders: &[Order],
        used: &[usize],
        each: usize,
        (fragments, inner): (usize, bool),
    ) -> Option<usize> {
        let costs = &self.job.options.costs;
        let nodes = |order: usize| orders[order].nodes() as f64;
        let count = |order: usize| each * self.selected.counts[order];
        let higher = |at: usize| used[at + 1..].iter().find(|higher| count(**higher) > 0);
        let pays = |at: usize, order: usize| match higher(at) {
            Some(&next) => {
                let saved = count(order) as f64 * (nodes(next) - nodes(order)) * costs.evaluation;
                saved > costs.draw + costs.interpolation * nodes(next)
            }
            None => {
                let inner = inner || used[..at].iter().any(|lower| count(*lower) > 0);
                self.is_worth(count(order), fragments, orders[order].side(), inner)
            }
        };
        let mut used = used.iter().copied().enumerate();
        used.find(|&(at, order)| count(order) > 0 && !pays(at, order)).map(|(at, _)| at)
    }
}

/// Returns the lamps of each order, and the indices of those of none.
fn by_order(orders: &[Order], lamps: &Lamps, selected: &Selected) -> (Vec<Taken>, Vec<u32>) {
    let none = orders.len();
    let mut ends = [0; ORDERS + 1];
    let mut last = 0;
    for (end, count) in ends.iter_mut().zip(&selected.counts[..none]) {
        *end = last;
        last += count;
    }
    ends[none] = last;
    let starts = ends;
    let mut sorted = vec![0; lamps.len()];
    let all = (0..).zip(lamps.places()).zip(&selected.orders);
    // The counts of a block are in one register, as a chain of writes to memory would take longer.
    let mut all = all.map(|((lamp, place), order)| (lamp, *place, *order as u32));
    for _ in (0..lamps.len()).step_by(MASK as usize) {
        let mut counts = 0u64;
        for (lamp, place, order) in all.by_ref().take(MASK as usize) {
            let shift = order * BITS;
            let at = ends[order as usize] + (counts >> shift & MASK) as usize;
            sorted[at] = if order as usize == none { lamp } else { place };
            counts += 1 << shift;
        }
        for (order, end) in (0..).zip(&mut ends) {
            *end += (counts >> (order * BITS) & MASK) as usize;
        }
    }
    let mut taken = Vec::with_capacity(none);
    for (order, (start, end)) in orders.iter().zip(starts.into_iter().zip(ends)) {
        if start < end {
            let places = sorted[start..end].to_vec();
            taken.push(Taken { side: order.side(), places, spent: 0.0 });
        }
    }
    // Which of them spends it is all the same.
    if let Some(first) = taken.first_mut() {
        first.spent = selected.spent * (1.0 + ROUNDING);
    }
    (taken, sorted.split_off(last))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::culling::lamps::Lamp;

    /// Each lamp is in the list of its order, in the order of all, also where there are more than one count
    /// holds.
    #[test]
    fn lamps_are_sorted_by_order() {
        let mut random = fastrand::Rng::with_seed(8);
        for len in [0, 1, 4094, 4095, 4096, 8191, 10_000] {
            for sides in [&[8][..], &[2, 4, 6, 8]] {
                let orders: Vec<Order> = sides.iter().map(|side| Order::new(*side)).collect();
                let lamp = |place: u32| Lamp {
                    place: place + 7,
                    position: DVec3::ZERO,
                    radius: 0.0,
                    attenuation: [1.0; 3],
                    terms: [1.0; 3],
                };
                let mut lamps = Lamps::for_many(len);
                lamps.extend(&(0..len as u32).map(lamp).collect::<Vec<_>>());
                let of: Vec<usize> = (0..len).map(|_| random.usize(0..=orders.len())).collect();
                let given = of.iter().map(|order| *order as f32).collect();
                let mut selected = Selected { orders: given, ..Selected::default() };
                let of_order = |order: usize| {
                    let lamps = (0..).zip(&of).filter(move |(_, of)| **of == order);
                    lamps.map(|(lamp, _)| lamp).collect::<Vec<u32>>()
                };
                for order in 0..orders.len() {
                    selected.counts[order] = of_order(order).len();
                }
                let (taken, kept) = by_order(&orders, &lamps, &selected);
                assert_eq!(kept, of_order(orders.len()));
                for (order, side) in sides.iter().enumerate() {
                    let places = taken.iter().find(|taken| taken.side == *side);
                    let places = places.map_or(Vec::new(), |taken| taken.places.clone());
                    let expected = of_order(order).iter().map(|lamp| lamp + 7).collect::<Vec<_>>();
                    assert_eq!(places, expected, "{len} lamps, order {side}");
                }
            }
        }
    }
}
