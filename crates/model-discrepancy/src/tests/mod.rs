//! Whether something is in the residual by more than chance, and what it predicts.

pub(crate) mod agreement;
pub(crate) mod cluster_robust;
pub(crate) mod f_test;
pub(crate) mod global_test;
pub(crate) mod groups_apart;
pub(crate) mod hold_out;
pub(crate) mod lack_of_fit;
pub(crate) mod law;
pub(crate) mod left_out;
pub(crate) mod odd_group;
pub(crate) mod odd_stretch;
pub(crate) mod pooled_scatter;
pub(crate) mod scatter_along;
pub(crate) mod significance;
pub(crate) mod tails;
pub(crate) mod under_noise;
pub(crate) mod vector_noise;
pub(crate) mod within_groups;
