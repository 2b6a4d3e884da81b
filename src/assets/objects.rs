//! The small things that come with the program: `assets/objects`, authors and licences in its MANIFEST.csv, and the
//! library that says what each kind of thing is like ([`library_text`]).

use super::bundle::{Bundle, bundle};
use super::{AssetError, Model};

static OBJECTS: Bundle = bundle! { "objects":
    "bag__backpack__BlendSwap-CC-BY.glb"
    "bag__handbag__BlendSwap-CC-0.glb"
    "bottle__beer_bottle__BlendSwap-CC-BY.glb"
    "bottle__red-wine-bottle-01__KatorLegaz.glb"
    "bottle__yogurtBottle__BlendSwap-CC-0.glb"
    "box__cardboard-box__Scopia.glb"
    "burger__hamburger__BlendSwap-CC-BY.glb"
    "cake__birthday_cake__Scopia.glb"
    "camera__basic_camera__Scopia.glb"
    "cell_phone__iphone__BlendSwap-CC-0.glb"
    "cell_phone__mobile__BlendSwap-CC-BY.glb"
    "chopping_board__choppingBoard__BlendSwap-CC-BY.glb"
    "clock__clock__BlendSwap-CC-BY.glb"
    "clothes__blouson__Scopia.glb"
    "clothes__jupe__Scopia.glb"
    "clothes__short-shadows__Scopia.glb"
    "computer__apple-imac-1998__KatorLegaz.glb"
    "cup__caffe_final__BlendSwap-CC-0.glb"
    "cup__coffee_cup__BlendSwap-CC-BY.glb"
    "cup__cup__Scopia.glb"
    "cupcake__cupcake__BlendSwap-CC-0.glb"
    "desk_lamp__desk_lamp1__Scopia.glb"
    "desk_lamp__desk_lamp2__Scopia.glb"
    "fork__fork__BlendSwap-CC-BY.glb"
    "fries__frenchFries__Scopia.glb"
    "fruit_bowl__apples__Scopia.glb"
    "fruit_bowl__bowlWithFruits__Scopia.glb"
    "glass__beerGlass__BlendSwap-CC-0.glb"
    "glass__highball-glass__KatorLegaz.glb"
    "glasses__glasses__Scopia.glb"
    "hat__casquette__Scopia.glb"
    "hat__chapeau__Scopia.glb"
    "headphones__headphones__BlendSwap-CC-0.glb"
    "hot_dog__hotDog__BlendSwap-CC-0.glb"
    "kettle__boiler__BlendSwap-CC-BY.glb"
    "kettle__espressokettle__BlendSwap-CC-BY.glb"
    "kitchen_knife__kitchenKnife__BlendSwap-CC-BY.glb"
    "knife__knife__BlendSwap-CC-BY.glb"
    "laptop__apple-ibook-2001__KatorLegaz.glb"
    "laptop__laptop__BlendSwap-CC-BY.glb"
    "microwave__microwave__BlendSwap-CC-BY.glb"
    "milk__tetrapak__BlendSwap-CC-0.glb"
    "monitor__apple_pc__Scopia.glb"
    "pen__pencil1__Scopia.glb"
    "pen__textMarker__BlendSwap-CC-0.glb"
    "phone__phone__Scopia.glb"
    "plant__cactus__BlendSwap-CC-0.glb"
    "plant__succulentPlant__BlendSwap-CC-BY.glb"
    "plate__dinner-plate__KatorLegaz.glb"
    "pot__largePan__BlendSwap-CC-BY.glb"
    "salad__bowlWithSalad__Scopia.glb"
    "salt__saltShaker__BlendSwap-CC-BY.glb"
    "scissors__cissors_swap__BlendSwap-CC-0.glb"
    "shoes__slippers__BlendSwap-CC-0.glb"
    "shoes__woman_shoes__Scopia.glb"
    "spoon__spoon__BlendSwap-CC-BY.glb"
    "stapler__stapler__KatorLegaz.glb"
    "teapot__teapot__Scopia.glb"
    "toaster__toaster__Scopia.glb"
    "toy__teddyBear__BlendSwap-CC-0.glb"
    "toy__toyTrain__BlendSwap-CC-BY.glb"
    "toy__woodToy__BlendSwap-CC-0.glb"
    "tray__tray__Scopia.glb"
    "tv__tv__Scopia.glb"
    "wine_glass__cocktailGlass__BlendSwap-CC-BY.glb"
    "wine_glass__glass__BlendSwap-CC-BY.glb"
};

/// File names of all bundled small things, in alphabetical order.
pub fn object_names() -> impl Iterator<Item = &'static str> {
    OBJECTS.names()
}

/// The bundled small thing of this file name; `None` if there is no such file.
///
/// # Errors
/// Never for an untouched program: what the reader says of a damaged file.
pub fn object_model(name: &str) -> Option<Result<Model, AssetError>> {
    OBJECTS.model(name)
}

/// The library of kinds as RON text: names, models, attitudes, where things may stand and how many a room takes.
pub fn library_text() -> &'static str {
    include_str!("../../assets/objects/library.ron")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bundled_thing_reads_stands_on_its_middle_and_is_light() {
        for name in object_names() {
            let model = object_model(name).expect("listed").expect(name);
            let bounds = model.bounds();
            assert!(bounds.min.y.abs() < 0.002, "{name} stands at {}", bounds.min.y);
            assert!(bounds.center().with_y(0.0).length() < 0.01, "{name} is off its middle");
            assert!(model.triangle_count() < 5000, "{name} has {} triangles", model.triangle_count());
            assert!(bounds.size().max_element() < 0.8, "{name} measures {} m", bounds.size());
        }
        assert!(object_model("no such file").is_none());
    }
}
