//! Buffers and textures: made, filled, read back.

use super::{Gpu, GpuError};
use bytemuck::Pod;

/// Usage of a buffer that compute passes read and write and the host may fill and copy from.
pub const STORAGE: wgpu::BufferUsages =
    wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::COPY_DST).union(wgpu::BufferUsages::COPY_SRC);

/// A storage buffer of `bytes` bytes (at least 16, rounded up to 4).
///
/// # Errors
/// When the adapter's largest binding is smaller.
pub fn storage(gpu: &Gpu, label: &str, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
    with_usage(gpu, label, bytes, STORAGE)
}

/// Bytes of the largest storage buffer that the adapter can bind whole.
#[must_use]
pub fn largest(gpu: &Gpu) -> u64 {
    let limits = gpu.device.limits();
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}

/// A buffer of `bytes` bytes (at least 16, rounded up to 4) with the given usage.
///
/// # Errors
/// When the adapter's largest storage binding is smaller.
pub fn with_usage(gpu: &Gpu, label: &str, bytes: u64, usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, GpuError> {
    let size = bytes.max(16).next_multiple_of(4);
    let allowed = largest(gpu);
    if size > allowed {
        return Err(GpuError::Limit {
            what: format!("buffer `{label}`"),
            needed: size,
            allowed,
            remedy: "choose a smaller grid or a simpler model",
        });
    }
    Ok(gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false }))
}

/// A storage buffer filled with `items`.
///
/// # Errors
/// When the adapter's largest binding is smaller.
pub fn storage_with<T: Pod>(gpu: &Gpu, label: &str, items: &[T]) -> Result<wgpu::Buffer, GpuError> {
    let bytes: &[u8] = bytemuck::cast_slice(items);
    let buffer = storage(gpu, label, bytes.len() as u64)?;
    gpu.queue.write_buffer(&buffer, 0, bytes);
    Ok(buffer)
}

/// A uniform buffer that holds one `T`.
#[must_use]
pub fn uniform<T: Pod>(gpu: &Gpu, label: &str, value: &T) -> wgpu::Buffer {
    let bytes = bytemuck::bytes_of(value);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: (bytes.len() as u64).next_multiple_of(16),
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, bytes);
    buffer
}

/// Waits for the device and reads `count` items of `buffer` from item `first`. Never called inside a frame.
///
/// # Errors
/// When the device is lost.
pub fn read<T: Pod>(gpu: &Gpu, buffer: &wgpu::Buffer, first: u64, count: usize) -> Result<Vec<T>, GpuError> {
    let item = size_of::<T>() as u64;
    let bytes = item * count as u64;
    if bytes == 0 {
        return Ok(Vec::new());
    }
    let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: bytes.next_multiple_of(4),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("readback") });
    encoder.copy_buffer_to_buffer(buffer, first * item, &staging, 0, bytes.next_multiple_of(4));
    gpu.queue.submit([encoder.finish()]);
    let data = map(gpu, &staging)?;
    Ok(bytemuck::pod_collect_to_vec(&data[..usize::try_from(bytes).unwrap_or(data.len())]))
}

/// Waits for the device and reads mip 0 of a 2D texture as tightly packed texels of type `T`, row by row from the top.
///
/// # Errors
/// When the device is lost.
pub fn read_texture<T: Pod>(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<T>, GpuError> {
    let (width, height) = (texture.width(), texture.height());
    let row = width * u32::try_from(size_of::<T>()).unwrap_or(u32::MAX);
    let pitch = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: u64::from(pitch) * u64::from(height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("readback") });
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &staging,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: None },
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
    gpu.queue.submit([encoder.finish()]);
    let data = map(gpu, &staging)?;
    let mut packed = Vec::with_capacity(row as usize * height as usize);
    for line in data.chunks_exact(pitch as usize) {
        packed.extend_from_slice(&line[..row as usize]);
    }
    Ok(bytemuck::pod_collect_to_vec(&packed))
}

fn map(gpu: &Gpu, staging: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
    let (sender, receiver) = std::sync::mpsc::channel();
    staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        // The receiver lives until the poll below returns.
        let _ = sender.send(result);
    });
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| GpuError::Lost(e.to_string()))?;
    receiver.recv().map_err(|e| GpuError::Lost(e.to_string()))?.map_err(|e| GpuError::Lost(e.to_string()))?;
    let view = staging.slice(..).get_mapped_range().map_err(|e| GpuError::Lost(e.to_string()))?;
    let data = view.to_vec();
    drop(view);
    staging.unmap();
    Ok(data)
}
