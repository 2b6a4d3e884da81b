//! The graphics device with everything on it that outlives a picture. Apart from any window: made by
//! itself (headless) or from the device that a window already has.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::RenderError;
use super::gpu::{PeopleCache, Pipelines, RoomCache, ShadowCache};

/// What went wrong on the device since it was made; filled by its callbacks.
#[derive(Debug, Default)]
struct Health {
    lost: Option<String>,
    refused: Option<String>,
}

/// What stays on the card between pictures.
#[derive(Default)]
pub(super) struct Cache {
    pub(super) room: RoomCache,
    pub(super) people: PeopleCache,
    pub(super) shadow: ShadowCache,
}

/// A graphics device, its pipelines and what was uploaded to it. Shared by reference between viewports;
/// pictures are drawn one at a time.
pub struct RenderContext {
    device: wgpu::Device,
    queue: wgpu::Queue,
    adapter: String,
    software: bool,
    health: Arc<Mutex<Health>>,
    pub(super) pipelines: Pipelines,
    cache: Mutex<Cache>,
}

impl RenderContext {
    /// A device of its own, for pictures without a window. Software adapters (llvmpipe, WARP) are welcome.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`] on a machine without any graphics driver, [`RenderError::NoDevice`],
    /// [`RenderError::Driver`] when the driver refuses the pipelines.
    pub fn headless() -> Result<Self, RenderError> {
        Self::headless_on(wgpu::Backends::PRIMARY)
    }

    /// As [`Self::headless`], on some kinds of driver only.
    fn headless_on(backends: wgpu::Backends) -> Result<Self, RenderError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .map_err(|e| RenderError::NoAdapter { detail: e.to_string() })?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("inhabit"),
            required_limits: wgpu::Limits::downlevel_defaults().using_resolution(adapter.limits()),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| RenderError::NoDevice { adapter: adapter.get_info().name, detail: e.to_string() })?;
        Self::from_device(device, queue)
    }

    /// On a device that a window already has (eframe's `RenderState`). Takes over the device's error and
    /// loss callbacks, so that neither ends the program.
    ///
    /// # Errors
    /// [`RenderError::Driver`] when the device cannot hold the pipelines.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, RenderError> {
        let health = Arc::new(Mutex::new(Health::default()));
        listen(&device, &health);
        let info = device.adapter_info();
        let software = info.device_type == wgpu::DeviceType::Cpu;
        let pipelines = Pipelines::new(&device);
        let context = Self {
            device,
            queue,
            adapter: info.name,
            software,
            health,
            pipelines,
            cache: Mutex::new(Cache::default()),
        };
        context.check()?;
        Ok(context)
    }

    /// Name of the adapter, for reports.
    pub fn adapter(&self) -> &str {
        &self.adapter
    }

    /// Whether the adapter is the processor itself: draw at [`super::Quality::Low`] while things move.
    pub fn is_software(&self) -> bool {
        self.software
    }

    /// The device, for registering a viewport's texture with a window toolkit.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue of the device.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Longest side in pixels that a picture can have.
    pub fn max_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }

    /// Whether the device still works. A refused call is told once; a lost device stays lost.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`], [`RenderError::Driver`].
    pub fn check(&self) -> Result<(), RenderError> {
        let mut health = lock(&self.health);
        if let Some(detail) = health.lost.clone() {
            return Err(RenderError::DeviceLost { detail });
        }
        match health.refused.take() {
            Some(detail) => Err(RenderError::Driver { detail }),
            None => Ok(()),
        }
    }

    pub(super) fn cache(&self) -> MutexGuard<'_, Cache> {
        lock(&self.cache)
    }
}

/// A panic elsewhere must not take the viewport with it: what the lock guards is rebuilt when it differs.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn listen(device: &wgpu::Device, health: &Arc<Mutex<Health>>) {
    let on_error = Arc::clone(health);
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        tracing::error!("graphics: {error}");
        lock(&on_error).refused.get_or_insert_with(|| error.to_string());
    }));
    let on_loss = Arc::clone(health);
    device.set_device_lost_callback(move |reason, message| {
        tracing::error!("graphics device lost ({reason:?}): {message}");
        lock(&on_loss).lost.get_or_insert_with(|| format!("{reason:?}: {message}"));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_without_adapter_gives_an_error_that_names_the_remedy() {
        let error =
            RenderContext::headless_on(wgpu::Backends::empty()).err().expect("no adapter can be found");
        assert!(matches!(error, RenderError::NoAdapter { .. }));
        assert!(error.to_string().contains("processor"), "{error}");
    }
}
