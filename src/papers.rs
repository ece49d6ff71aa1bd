//! The papers that the methods come from: one constant each, named wherever a method opens.

/// A source.
#[derive(Debug, PartialEq, Eq)]
pub struct Paper {
    /// Authors and year, as the docs cite it.
    pub short: &'static str,
    /// Title.
    pub title: &'static str,
    /// Where it appeared.
    pub venue: &'static str,
}

/// CL: the main source. Slices amplified in one pass; shadows, transmittance, refraction.
pub const CHANG_LAI_2011: Paper = Paper {
    short: "Chang & Lai 2011",
    title: "Real-time GPU-Based Voxelization and Applications",
    venue: "University of Wisconsin–Madison, Computer Sciences Technical Report 1688",
};
/// RB: triangle-parallel, fragment-parallel and hybrid voxelization, 26- and 6-separating.
pub const RAUWENDAAL_BAILEY_2013: Paper = Paper {
    short: "Rauwendaal & Bailey 2013",
    title: "Hybrid Computational Voxelization Using the Graphics Pipeline",
    venue: "Journal of Computer Graphics Techniques 2(1)",
};
/// TR: a survey with its own exact method; Akenine-Möller 2001, Hasselgren 2005, Eisemann & Décoret 2006/2008 inside.
pub const TRIPIANA_2009: Paper =
    Paper { short: "Tripiana 2009", title: "GPU Voxelization", venue: "Master's thesis, UPC Barcelona" };
/// DO: three directional sheet buffers, merged into a worksheet.
pub const DONG_2004: Paper = Paper {
    short: "Dong et al. 2004",
    title: "Real-time Voxelization for Complex Polygonal Models",
    venue: "Pacific Graphics 2004",
};
/// A bit by depth in each column, one pass; in TR §1.4.2.
pub const EISEMANN_DECORET_2006: Paper = Paper {
    short: "Eisemann & Décoret 2006",
    title: "Fast Scene Voxelization and Applications",
    venue: "Symposium on Interactive 3D Graphics and Games 2006",
};
/// Solids from the parity of the surfaces beyond each cell, one pass; in TR §1.4.3.
pub const EISEMANN_DECORET_2008: Paper = Paper {
    short: "Eisemann & Décoret 2008",
    title: "Single-Pass GPU Solid Voxelization for Real-Time Applications",
    venue: "Graphics Interface 2008",
};
/// A pass a slice; the parity of the slices before tells inside from outside.
pub const FANG_CHEN_2000: Paper = Paper {
    short: "Fang & Chen 2000",
    title: "Hardware Accelerated Voxelization",
    venue: "Computers & Graphics 24(3)",
};
/// MD: a simplified voxel visualization.
pub const MILEFF_DUDRA_2019: Paper = Paper {
    short: "Mileff & Dudra 2019",
    title: "Simplified Voxel Based Visualization",
    venue: "Production Systems and Information Engineering 8",
};
/// The separating-axis test for a triangle and a box, as TR §1.4.1 gives it.
pub const AKENINE_MOLLER_2001: Paper = Paper {
    short: "Akenine-Möller 2001",
    title: "Fast 3D Triangle-Box Overlap Testing",
    venue: "Journal of Graphics Tools 6(1)",
};
