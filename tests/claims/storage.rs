//! Dense volumes and our records, stored side by side and marched by the same marcher.

use crate::gpu;
use murrine::bench;
use murrine::dense::Storage;

#[test]
fn records_take_less_than_any_dense_volume_and_refract_as_the_finest_does() {
    let report = bench::storage(gpu(), &[32, 96], 96, 3, |_| {}).unwrap();
    assert_eq!(report.rows.len(), 8);
    for (rows, most_deg) in report.rows.chunks(4).zip([3.0, 1.0]) {
        let [records, float32, float16, snorm8] = rows else { panic!("four storages") };
        let named: Vec<&str> = rows.iter().map(|r| r.storage).collect();
        assert_eq!(named, Storage::ALL.map(Storage::name));
        assert_eq!((float32.bytes, float16.bytes), (2 * float16.bytes, 2 * snorm8.bytes));
        for row in rows {
            assert!(row.median_deg > 0.0 && row.median_deg < most_deg, "{row:?}");
            assert!(row.march.min > 0.0, "{row:?}");
        }
        // The same normals up to rounding: 16 bits octahedral, 10 bits of a half, 7 of a byte.
        assert!((float32.median_deg - records.median_deg).abs() < 1e-3, "{records:?} {float32:?}");
        assert!((float16.median_deg - records.median_deg).abs() < 0.02, "{records:?} {float16:?}");
        assert!((snorm8.median_deg - records.median_deg).abs() < 0.5, "{records:?} {snorm8:?}");
        // The negative control: rounding to eight bits is seen, and more than rounding to sixteen.
        let moved = |row: &bench::StorageRow| {
            (row.p95_deg - float32.p95_deg).abs().max((row.median_deg - float32.median_deg).abs())
        };
        assert!(moved(snorm8) > 1e-4 && moved(snorm8) > moved(float16), "{float32:?} {float16:?} {snorm8:?}");
        assert!(records.bytes < snorm8.bytes || records.cells < 64, "{records:?} {snorm8:?}");
    }
    let [coarse, fine] = report.lists.as_slice() else { panic!("two grids") };
    assert!(coarse.voxels > 1000 && fine.voxels > 6 * coarse.voxels, "{coarse:?} {fine:?}");
    let table = report.table();
    assert!(table.contains("dense, 8-bit RGBA") && table.contains("by locks"), "{table}");
}
