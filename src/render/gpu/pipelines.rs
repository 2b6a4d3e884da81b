//! Every pipeline and layout, made once per device.

use super::{marks, people, room};

/// Format of the drawn picture: linear in the shader, stored as sRGB; alpha says how much of the light is
/// indirect, for the occlusion pass.
pub const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// Format of the shown picture: sRGB bytes, as window toolkits and PNG files take them.
pub const SHOWN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of depth, in the picture and in the shadow map.
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Format of the selection's flags.
pub const FLAGS: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;
/// Format of occlusion and distance.
pub const OCCLUSION: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Float;
/// Samples per pixel; 4 is what every device can do.
pub const SAMPLES: u32 = 4;

/// What bind groups are made with.
pub struct Layouts {
    /// Group 0 of passes that are not lit: the frame.
    pub frame: wgpu::BindGroupLayout,
    /// Group 0 of lit passes: the frame, shadow map and its sampler.
    pub lit: wgpu::BindGroupLayout,
    /// Group 1 of the room: material, texture, sampler.
    pub material: wgpu::BindGroupLayout,
    /// Group 1 of people: the outfit.
    pub person: wgpu::BindGroupLayout,
    /// Group 0 of the finishing passes.
    pub finish: wgpu::BindGroupLayout,
}

/// How textures are read.
pub struct Samplers {
    /// Textures of materials.
    pub texture: wgpu::Sampler,
    /// Depths of the shadow map.
    pub shadow: wgpu::Sampler,
    /// Pictures, between pixels.
    pub smooth: wgpu::Sampler,
}

/// Every pipeline, and the layouts that bind groups are made with.
pub struct Pipelines {
    pub layouts: Layouts,
    pub samplers: Samplers,
    pub room_opaque: wgpu::RenderPipeline,
    pub room_masked: wgpu::RenderPipeline,
    pub room_blend: wgpu::RenderPipeline,
    pub room_shadow: wgpu::RenderPipeline,
    pub room_flag: wgpu::RenderPipeline,
    pub person_solid: wgpu::RenderPipeline,
    /// Where a ghost is nearest; drawn before its colour, so that its back does not shine through.
    pub ghost_depth: wgpu::RenderPipeline,
    pub ghost_color: wgpu::RenderPipeline,
    pub person_shadow: wgpu::RenderPipeline,
    pub person_flag: wgpu::RenderPipeline,
    pub grid: wgpu::RenderPipeline,
    /// Hidden by what is in front, on top.
    pub lines: [wgpu::RenderPipeline; 2],
    /// Hidden by what is in front, on top.
    pub points: [wgpu::RenderPipeline; 2],
    pub occlusion: wgpu::RenderPipeline,
    pub blur: wgpu::RenderPipeline,
    pub compose: wgpu::RenderPipeline,
}

impl Pipelines {
    /// Makes everything; the device's error callback hears of what it refuses.
    pub fn new(device: &wgpu::Device) -> Self {
        let layouts = Layouts::new(device);
        let shaders = Shaders::new(device);
        let room = Recipe {
            groups: &[Some(&layouts.lit), Some(&layouts.material)],
            buffers: &room::BUFFERS,
            ..Recipe::new(device, "room", &shaders.surface)
        };
        let room_shadow = Recipe { groups: &[Some(&layouts.frame), Some(&layouts.material)], ..room };
        let person = Recipe {
            groups: &[Some(&layouts.lit), Some(&layouts.person)],
            buffers: &people::BUFFERS,
            // Bodies are closed: their inside is never seen.
            cull: Some(wgpu::Face::Back),
            ..Recipe::new(device, "person", &shaders.people)
        };
        let person_shadow = Recipe { groups: &[Some(&layouts.frame)], ..person };
        let ground = Recipe {
            groups: &[Some(&layouts.lit)],
            strip: true,
            ..Recipe::new(device, "ground", &shaders.grid)
        };
        let mark = Recipe {
            groups: &[Some(&layouts.frame)],
            buffers: &marks::BUFFERS,
            strip: true,
            ..Recipe::new(device, "mark", &shaders.marks)
        };
        let finish =
            Recipe { groups: &[Some(&layouts.finish)], ..Recipe::new(device, "finish", &shaders.finish) };
        let marks_of = |vs| {
            [DepthUse::TEST, DepthUse::IGNORE].map(|depth| mark.make(vs, Some("fs"), depth, Paint::Blend))
        };
        Self {
            room_opaque: room.make("vs", Some("fs_opaque"), DepthUse::WRITE, Paint::Solid),
            room_masked: room.make("vs", Some("fs_masked"), DepthUse::WRITE, Paint::Solid),
            room_blend: room.make("vs", Some("fs_blend"), DepthUse::TEST, Paint::Blend),
            room_shadow: room_shadow.make("vs_shadow", Some("fs_shadow"), DepthUse::SHADOW, Paint::None),
            room_flag: room.make("vs", Some("fs_flag"), DepthUse::NONE, Paint::Target(FLAGS, SAMPLES)),
            person_solid: person.make("vs", Some("fs_solid"), DepthUse::WRITE, Paint::Solid),
            ghost_depth: person.make("vs", Some("fs_ghost"), DepthUse::WRITE, Paint::Nothing),
            ghost_color: person.make("vs", Some("fs_ghost"), DepthUse::TEST, Paint::Blend),
            person_shadow: person_shadow.make("vs_shadow", None, DepthUse::SHADOW, Paint::None),
            person_flag: person.make("vs", Some("fs_flag"), DepthUse::NONE, Paint::Target(FLAGS, SAMPLES)),
            grid: ground.make("vs", Some("fs"), DepthUse::TEST, Paint::Blend),
            lines: marks_of("vs_line"),
            points: marks_of("vs_point"),
            occlusion: finish.make("vs", Some("fs_occlusion"), DepthUse::NONE, Paint::Target(OCCLUSION, 1)),
            blur: finish.make("vs", Some("fs_blur"), DepthUse::NONE, Paint::Target(OCCLUSION, 1)),
            compose: finish.make("vs", Some("fs_compose"), DepthUse::NONE, Paint::Target(SHOWN, 1)),
            samplers: Samplers::new(device),
            layouts,
        }
    }
}

impl Layouts {
    fn new(device: &wgpu::Device) -> Self {
        let make = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let finish = [uniform(0), multisampled_depth(1), picture(2), picture(3), picture(4), filtering(5)];
        Self {
            frame: make("frame", &[uniform(0)]),
            lit: make("lit", &[uniform(0), depth_texture(1), comparison(2)]),
            material: make("material", &[uniform(0), picture(1), filtering(2)]),
            person: make("person", &[uniform(0)]),
            finish: make("finish", &finish),
        }
    }
}

impl Samplers {
    fn new(device: &wgpu::Device) -> Self {
        // Software adapters pay for anisotropy with most of the frame.
        let software = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let linear = wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        };
        Self {
            texture: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("texture"),
                address_mode_u: wgpu::AddressMode::Repeat,
                address_mode_v: wgpu::AddressMode::Repeat,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                anisotropy_clamp: if software { 1 } else { 8 },
                ..linear
            }),
            shadow: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("shadow"),
                compare: Some(wgpu::CompareFunction::LessEqual),
                ..linear
            }),
            smooth: device.create_sampler(&linear),
        }
    }
}

struct Shaders {
    surface: wgpu::ShaderModule,
    people: wgpu::ShaderModule,
    grid: wgpu::ShaderModule,
    marks: wgpu::ShaderModule,
    finish: wgpu::ShaderModule,
}

impl Shaders {
    fn new(device: &wgpu::Device) -> Self {
        const FRAME: &str = include_str!("../shaders/frame.wgsl");
        const LIGHT: &str = include_str!("../shaders/light.wgsl");
        let make = |label, parts: &[&str]| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(parts.concat().into()),
            })
        };
        Self {
            surface: make("surface", &[FRAME, LIGHT, include_str!("../shaders/surface.wgsl")]),
            people: make("people", &[FRAME, LIGHT, include_str!("../shaders/people.wgsl")]),
            grid: make("grid", &[FRAME, LIGHT, include_str!("../shaders/grid.wgsl")]),
            marks: make("marks", &[FRAME, include_str!("../shaders/marks.wgsl")]),
            finish: make("finish", &[include_str!("../shaders/finish.wgsl")]),
        }
    }
}

/// What a pipeline does with depth.
#[derive(Clone, Copy)]
struct DepthUse(Option<(wgpu::CompareFunction, bool, wgpu::DepthBiasState)>);

impl DepthUse {
    const NO_BIAS: wgpu::DepthBiasState = wgpu::DepthBiasState { constant: 0, slope_scale: 0.0, clamp: 0.0 };
    const NONE: Self = Self(None);
    const WRITE: Self = Self(Some((wgpu::CompareFunction::LessEqual, true, Self::NO_BIAS)));
    const TEST: Self = Self(Some((wgpu::CompareFunction::LessEqual, false, Self::NO_BIAS)));
    const IGNORE: Self = Self(Some((wgpu::CompareFunction::Always, false, Self::NO_BIAS)));
    /// Pushed back by its slope within a texel; the receiver's lift does the rest.
    const SHADOW: Self = Self(Some((
        wgpu::CompareFunction::LessEqual,
        true,
        wgpu::DepthBiasState { constant: 0, slope_scale: 1.5, clamp: 0.0 },
    )));

    fn state(self) -> Option<wgpu::DepthStencilState> {
        self.0.map(|(compare, write, bias)| wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(write),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias,
        })
    }
}

/// What a pipeline does with colour.
#[derive(Clone, Copy)]
enum Paint {
    /// No colour target: the shadow map.
    None,
    /// Into the picture, replacing.
    Solid,
    /// Into the picture, over what is there; its alpha stays.
    Blend,
    /// Into the picture's pass without touching the colour.
    Nothing,
    /// Into a target of its own.
    Target(wgpu::TextureFormat, u32),
}

impl Paint {
    fn target(self) -> Option<wgpu::ColorTargetState> {
        let state = |format, blend, write_mask| Some(wgpu::ColorTargetState { format, blend, write_mask });
        match self {
            Self::None => None,
            Self::Solid => state(COLOR, None, wgpu::ColorWrites::ALL),
            Self::Blend => state(COLOR, Some(wgpu::BlendState::ALPHA_BLENDING), wgpu::ColorWrites::COLOR),
            Self::Nothing => state(COLOR, None, wgpu::ColorWrites::empty()),
            Self::Target(format, _) => state(format, None, wgpu::ColorWrites::ALL),
        }
    }

    fn samples(self) -> u32 {
        match self {
            Self::None => 1,
            Self::Solid | Self::Blend | Self::Nothing => SAMPLES,
            Self::Target(_, samples) => samples,
        }
    }
}

/// What the pipelines of one shader have in common.
#[derive(Clone, Copy)]
struct Recipe<'a> {
    device: &'a wgpu::Device,
    label: &'a str,
    shader: &'a wgpu::ShaderModule,
    groups: &'a [Option<&'a wgpu::BindGroupLayout>],
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    strip: bool,
    cull: Option<wgpu::Face>,
}

impl<'a> Recipe<'a> {
    fn new(device: &'a wgpu::Device, label: &'a str, shader: &'a wgpu::ShaderModule) -> Self {
        Self { device, label, shader, groups: &[], buffers: &[], strip: false, cull: None }
    }

    fn make(&self, vs: &str, fs: Option<&str>, depth: DepthUse, paint: Paint) -> wgpu::RenderPipeline {
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.label),
            bind_group_layouts: self.groups,
            immediate_size: 0,
        });
        let target = paint.target();
        let targets = [target.clone()];
        let topology = match self.strip {
            true => wgpu::PrimitiveTopology::TriangleStrip,
            false => wgpu::PrimitiveTopology::TriangleList,
        };
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: self.shader,
                entry_point: Some(vs),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: self.buffers,
            },
            primitive: wgpu::PrimitiveState {
                topology,
                cull_mode: self.cull,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: depth.state(),
            multisample: wgpu::MultisampleState {
                count: paint.samples(),
                ..wgpu::MultisampleState::default()
            },
            fragment: fs.map(|entry| wgpu::FragmentState {
                module: self.shader,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: if target.is_some() { &targets } else { &[] },
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::VERTEX_FRAGMENT, ty, count: None }
}

fn uniform(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    entry(binding, ty)
}

fn texture(binding: u32, sample_type: wgpu::TextureSampleType, multi: bool) -> wgpu::BindGroupLayoutEntry {
    let view_dimension = wgpu::TextureViewDimension::D2;
    entry(binding, wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: multi })
}

fn picture(binding: u32) -> wgpu::BindGroupLayoutEntry {
    texture(binding, wgpu::TextureSampleType::Float { filterable: true }, false)
}

fn depth_texture(binding: u32) -> wgpu::BindGroupLayoutEntry {
    texture(binding, wgpu::TextureSampleType::Depth, false)
}

fn multisampled_depth(binding: u32) -> wgpu::BindGroupLayoutEntry {
    texture(binding, wgpu::TextureSampleType::Depth, true)
}

fn filtering(binding: u32) -> wgpu::BindGroupLayoutEntry {
    entry(binding, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering))
}

fn comparison(binding: u32) -> wgpu::BindGroupLayoutEntry {
    entry(binding, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison))
}
