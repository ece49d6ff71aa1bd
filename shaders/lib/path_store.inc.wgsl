#include "lib/path.inc.wgsl"
// Stores a path where `shade` finds it, and puts questionable pixels on a list for `repair`.
//
// Bind as: var path_place, path_way, path_first: texture_storage_2d<rgba32float, write>;
//          var path_depth: texture_storage_2d<rgba32uint, write>;
//          var<storage, read_write> questionable: array<atomic<u32>>;
//
// The list: three numbers of workgroups for an indirect dispatch of 64 threads each, the count, then the pixels,
// x | y << 16. Their order is as chance has it; nothing that is worked out from them hangs on it.

const LIST_COUNT: u32 = 3u;
const LIST_PIXELS: u32 = 4u;

fn store_path(pixel: vec2u, path: Path) {
    textureStore(path_place, pixel, path_place_texel(path));
    textureStore(path_way, pixel, path_way_texel(path));
    textureStore(path_depth, pixel, path_depth_texel(path));
    textureStore(path_first, pixel, path_first_texel(path));
    if path.questionable {
        let number = atomicAdd(&questionable[LIST_COUNT], 1u);
        atomicStore(&questionable[LIST_PIXELS + number], pixel.x | (pixel.y << 16u));
        atomicMax(&questionable[0], number / 64u + 1u);
        atomicMax(&questionable[1], 1u);
        atomicMax(&questionable[2], 1u);
    }
}
