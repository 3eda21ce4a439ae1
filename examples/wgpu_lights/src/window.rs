//! The floor in a window: one triangle, each pixel lit by all lights of the uniform buffer.

use std::error::Error;
use std::sync::Arc;

use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalSize};
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowId};

use crate::gpu::wgpu_bindings::window as bindings;
use crate::{Gpu, instance};

/// Opens the window, draws into it and returns when it is closed.
pub fn show(upload: &[u8]) -> Result<(), Box<dyn Error>> {
    let mut app = App { upload, view: None, failed: None };
    EventLoop::new()?.run_app(&mut app)?;
    app.failed.map_or(Ok(()), Err)
}

struct App<'u> {
    upload: &'u [u8],
    /// There is none before the event loop runs.
    view: Option<View>,
    /// What ended the event loop.
    failed: Option<Box<dyn Error>>,
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        match View::open(events, self.upload) {
            Ok(view) => self.view = Some(view),
            Err(error) => {
                self.failed = Some(error);
                events.exit();
            }
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(view) = &mut self.view else { return };
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => view.resize(size),
            WindowEvent::RedrawRequested => {
                if let Err(error) = view.draw() {
                    self.failed = Some(error);
                    events.exit();
                }
            }
            _ => {}
        }
    }
}

struct View {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    gpu: Gpu,
    pipeline: wgpu::RenderPipeline,
    lights: wgpu::BindGroup,
}

impl View {
    fn open(events: &ActiveEventLoop, upload: &[u8]) -> Result<View, Box<dyn Error>> {
        let attributes = Window::default_attributes()
            .with_title("128 lights of a uniform buffer")
            .with_inner_size(LogicalSize::new(1024, 256));
        let window = Arc::new(events.create_window(attributes)?);
        let instance = instance();
        let surface = instance.create_surface(window.clone())?;
        let gpu = Gpu::open(&instance, Some(&surface))?;
        let size = window.inner_size();
        let config = surface
            .get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))
            .ok_or("the adapter cannot draw to this window")?;
        surface.configure(&gpu.device, &config);
        let uniform = gpu.uniform(upload);
        let module = bindings::shader_module(&gpu.device);
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("floor"),
            layout: Some(&bindings::pipeline_layout(&gpu.device)),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(bindings::CORNER_ENTRY),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(bindings::SHADE_ENTRY),
                compilation_options: Default::default(),
                targets: &[Some(config.format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let lights = bindings::Group0 { scene: uniform.as_entire_buffer_binding() }
            .bind(&gpu.device, &bindings::Group0::layout(&gpu.device));
        Ok(View { window, surface, config, gpu, pipeline, lights })
    }

    /// A window of no pixels, such as a minimised one, keeps its last size.
    fn resize(&mut self, size: PhysicalSize<u32>) {
        if size.width > 0 && size.height > 0 {
            (self.config.width, self.config.height) = (size.width, size.height);
            self.surface.configure(&self.gpu.device, &self.config);
            self.window.request_redraw();
        }
    }

    /// Draws one picture; the scene stands still, so the next is drawn when the window changes.
    fn draw(&self) -> Result<(), Box<dyn Error>> {
        use wgpu::CurrentSurfaceTexture as Current;
        let texture = match self.surface.get_current_texture() {
            Current::Success(texture) | Current::Suboptimal(texture) => texture,
            Current::Outdated => {
                self.surface.configure(&self.gpu.device, &self.config);
                self.window.request_redraw();
                return Ok(());
            }
            Current::Timeout | Current::Occluded => return Ok(()),
            Current::Lost | Current::Validation => return Err("the surface is lost".into()),
        };
        let target = texture.texture.create_view(&Default::default());
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target,
                depth_slice: None,
                resolve_target: None,
                ops: Default::default(),
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(bindings::Group0::INDEX, &self.lights, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.queue.present(texture);
        Ok(())
    }
}
