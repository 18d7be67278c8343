// Generated from material/src/properties.rs; a test keeps it current. Do not edit.

// One row per property, in the order of the specification: the value in xyz, the texture slot or -1 in w.
struct MaterialRows {
    base_color: vec4f,
    roughness: vec4f,
    metallic: vec4f,
    opacity: vec4f,
    specular_level: vec4f,
    specular_edge_color: vec4f,
    normal: vec4f,
    normal_scale: vec4f,
    combine_normal_and_height: vec4f,
    height: vec4f,
    height_scale: vec4f,
    height_level: vec4f,
    anisotropy: vec4f,
    anisotropy_rotation: vec4f,
    emission: vec4f,
    emission_color: vec4f,
    sheen: vec4f,
    sheen_color: vec4f,
    sheen_roughness: vec4f,
    translucency: vec4f,
    specular_ior: vec4f,
    dispersion: vec4f,
    absorption_color: vec4f,
    absorption_distance: vec4f,
    scatter: vec4f,
    scatter_color: vec4f,
    scatter_distance: vec4f,
    scatter_distance_scale: vec4f,
    scatter_red_shift: vec4f,
    scatter_rayleigh: vec4f,
    coat: vec4f,
    coat_color: vec4f,
    coat_roughness: vec4f,
    coat_ior: vec4f,
    coat_specular_level: vec4f,
    coat_normal: vec4f,
    coat_normal_scale: vec4f,
    ambient_occlusion: vec4f,
    volume_thickness: vec4f,
    volume_thickness_scale: vec4f,
}

// All property values at one shading point, textures already sampled.
struct Inputs {
    // Ideal colour at normal incidence: diffuse reflection of dielectrics, specular reflection of metals.
    base_color: vec3f,
    // Roughness of the surface reflections and refractions; 0 is a perfect mirror.
    roughness: f32,
    // Whether the surface behaves as a dielectric (0) or a conductor (1). Metal has priority over translucency.
    metallic: f32,
    // Cut-through opacity without refraction, evaluated at each interface: 0 is not there, 1 is opaque.
    opacity: f32,
    // Modifier of the index of refraction, linear in reflectivity: 0.5 leaves it, 0 removes the reflection, 1 doubles it. Dielectrics only.
    specular_level: f32,
    // Tints dielectric reflections at every angle and metallic reflections at grazing angles (F82 tint).
    specular_edge_color: vec3f,
    // Tangent-space normal map of the surface, OpenGL orientation (+Y up).
    normal: vec3f,
    // Strength of the normal map; 0 switches it off.
    normal_scale: f32,
    // Whether the normal map is added to the detail of the height map (true) or already contains it (false).
    combine_normal_and_height: bool,
    // Displacement along the normal; no displacement where it equals the height level.
    height: f32,
    // Size of the displacement between height 0 and height 1.
    height_scale: f32,
    // Value of the height map that means no displacement.
    height_level: f32,
    // How far the highlight is stretched along the direction of anisotropy; visible at any roughness below 1.
    anisotropy: f32,
    // Counterclockwise rotation of the stretch from the tangent; 1 is a full turn, half a turn looks the same as none.
    anisotropy_rotation: f32,
    // Multiplier of the emitted radiance.
    emission: f32,
    // Colour of the emitted light when the emission is 1.
    emission_color: vec3f,
    // Amount of the lustre of woven fibres.
    sheen: f32,
    // Colour of the sheen.
    sheen_color: vec3f,
    // Range of angles at which the sheen is seen: low values keep it at the silhouette.
    sheen_roughness: f32,
    // Amount of refraction into the body. Metal does not transmit.
    translucency: f32,
    // Index of refraction of the dielectric relative to its surroundings, for reflection and refraction.
    specular_ior: f32,
    // Chromatic dispersion as 20 divided by the Abbe number. Real glasses lie between 0 and 1, few crystals above.
    dispersion: f32,
    // Colour of white light after the absorption distance in the body.
    absorption_color: vec3f,
    // Depth at which the absorption colour is reached. At 0 the colour tints each crossing of the surface instead, whatever the size.
    absorption_distance: f32,
    // Enables scattering in the body where translucency is above 0 or opacity below 1.
    scatter: bool,
    // Overall colour that scattering gives a thick body.
    scatter_color: vec3f,
    // Mean free path of the brightest channel: lower values make the body denser.
    scatter_distance: f32,
    // Scales the scattering distance by channel.
    scatter_distance_scale: vec3f,
    // Lets red light travel up to ten times further, as blood does in skin.
    scatter_red_shift: f32,
    // Scatters blue light sooner than red, as small particles do in milk, skin and smoke.
    scatter_rayleigh: f32,
    // Presence of the coat, a dielectric layer above everything else.
    coat: f32,
    // Tint that the coat gives to all that is seen through it; its own reflection stays untinted.
    coat_color: vec3f,
    // Roughness of the coat's own reflection.
    coat_roughness: f32,
    // Index of refraction of the coat; it also weakens the reflection of a dielectric below.
    coat_ior: f32,
    // Modifier of the coat's reflectivity, as the specular level is for the base.
    coat_specular_level: f32,
    // Tangent-space normal map of the coat alone, OpenGL orientation (+Y up).
    coat_normal: vec3f,
    // Strength of the coat's normal map; 0 switches it off.
    coat_normal_scale: f32,
    // Share of indirect light that reaches the surface. Rasterisers use it; the path tracer computes occlusion itself.
    ambient_occlusion: f32,
    // Mean thickness of the body below the surface as a fraction of the bounding box width. Rasterisers use it.
    volume_thickness: f32,
    // Multiplier of the volume thickness.
    volume_thickness_scale: f32,
}

fn inputs_from_rows(rows: MaterialRows) -> Inputs {
    return Inputs(
        rows.base_color.xyz,
        rows.roughness.x,
        rows.metallic.x,
        rows.opacity.x,
        rows.specular_level.x,
        rows.specular_edge_color.xyz,
        rows.normal.xyz,
        rows.normal_scale.x,
        rows.combine_normal_and_height.x > 0.5,
        rows.height.x,
        rows.height_scale.x,
        rows.height_level.x,
        rows.anisotropy.x,
        rows.anisotropy_rotation.x,
        rows.emission.x,
        rows.emission_color.xyz,
        rows.sheen.x,
        rows.sheen_color.xyz,
        rows.sheen_roughness.x,
        rows.translucency.x,
        rows.specular_ior.x,
        rows.dispersion.x,
        rows.absorption_color.xyz,
        rows.absorption_distance.x,
        rows.scatter.x > 0.5,
        rows.scatter_color.xyz,
        rows.scatter_distance.x,
        rows.scatter_distance_scale.xyz,
        rows.scatter_red_shift.x,
        rows.scatter_rayleigh.x,
        rows.coat.x,
        rows.coat_color.xyz,
        rows.coat_roughness.x,
        rows.coat_ior.x,
        rows.coat_specular_level.x,
        rows.coat_normal.xyz,
        rows.coat_normal_scale.x,
        rows.ambient_occlusion.x,
        rows.volume_thickness.x,
        rows.volume_thickness_scale.x,
    );
}
