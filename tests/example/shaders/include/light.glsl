// A point light as every shader here sees it.
struct PointLight {
    vec3 position; // in world space
    vec3 color;    // linear
    float intensity;
    float range;   // beyond it the light is off
};
