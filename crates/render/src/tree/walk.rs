use super::RayTree;
use super::node::{LEAF, WIDTH};
use super::ray::{PortableSigns, SignBits, TreeRay};
use pulp::{Arch, Simd, WithSimd};

/// Places of nodes that wait: eight children at a time on at most twenty levels, of which the
/// builder takes care.
const WAITING: usize = 160;

/// The things in the leaves of a tree.
pub(crate) trait Leaves {
    /// What is found.
    type Found;

    /// Looks for the ray in the leaf; shortens it where it is met.
    fn meet<S: Simd, B: SignBits>(
        &mut self,
        registers: (S, B),
        leaf: usize,
        ray: &mut TreeRay,
    ) -> Option<Self::Found>;
}

/// What is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RayQuery {
    /// The nearest thing.
    Nearest,
    /// Any thing.
    Any,
}

/// Finds what a ray meets in a tree.
pub(crate) fn walk<L: Leaves>(
    tree: &RayTree,
    leaves: &mut L,
    ray: &mut TreeRay,
    until: RayQuery,
) -> Option<L::Found> {
    let kernel = WalkKernel { tree, leaves, ray, until };
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(WithSigns { simd, kernel });
    }
    Arch::new().dispatch(kernel)
}

struct WalkKernel<'a, L> {
    tree: &'a RayTree,
    leaves: &'a mut L,
    ray: &'a mut TreeRay,
    until: RayQuery,
}

impl<L: Leaves> WithSimd for WalkKernel<'_, L> {
    type Output = Option<L::Found>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        self.run((simd, PortableSigns))
    }
}

#[cfg(target_arch = "x86_64")]
struct WithSigns<'a, L> {
    simd: pulp::x86::V3,
    kernel: WalkKernel<'a, L>,
}

#[cfg(target_arch = "x86_64")]
impl<L: Leaves> pulp::NullaryFnOnce for WithSigns<'_, L> {
    type Output = Option<L::Found>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.kernel.run((self.simd, self.simd))
    }
}

impl<L: Leaves> WalkKernel<'_, L> {
    /// Nodes wait with the distance at which the ray enters them; the nearest is next.
    #[inline(always)]
    fn run<S: Simd, B: SignBits>(self, registers: (S, B)) -> Option<L::Found> {
        let Self { tree, leaves, ray, until } = self;
        if tree.nodes.is_empty() {
            return None;
        }
        let mut waiting = [(0_u32, 0.0_f32); WAITING];
        let mut count = 1;
        let mut found = None;
        let mut near = [0.0; WIDTH];
        while count > 0 {
            count -= 1;
            let (child, entered) = waiting[count];
            if entered > ray.end {
                continue;
            }
            if child & LEAF != 0 {
                if let Some(thing) = leaves.meet(registers, (child ^ LEAF) as usize, ray) {
                    found = Some(thing);
                    if until == RayQuery::Any {
                        break;
                    }
                }
                continue;
            }
            let node = &tree.nodes[child as usize];
            let mut met = ray.meet(registers, node, &mut near);
            let first = count;
            while met != 0 {
                let lane = met.trailing_zeros() as usize % WIDTH;
                met &= met - 1;
                let new = (node.children[lane], near[lane]);
                // The farthest first, by insertion: few are met at a time.
                let mut place = count;
                while place > first && waiting[place - 1].1 < new.1 {
                    waiting[place] = waiting[place - 1];
                    place -= 1;
                }
                waiting[place] = new;
                count += 1;
            }
        }
        found
    }
}
