//! The furniture models that come with the program: `assets/furniture`, authors and licences in its MANIFEST.csv.

use super::bundle::{Bundle, bundle};
use super::{AssetError, Model};

/// Every model, in the order of the names.
static FURNITURE: Bundle = bundle! { "furniture":
    "armchair__armChair2__BlendSwap-CC-BY.glb"
    "armchair__armchair1__BlendSwap-CC-BY.glb"
    "armchair__armchair1__Scopia.glb"
    "armchair__armchair2__BlendSwap-CC-0.glb"
    "armchair__armchair3__Scopia.glb"
    "armchair__armchair__Scopia.glb"
    "armchair__designChair__BlendSwap-CC-0.glb"
    "armchair__fotel__BlendSwap-CC-BY.glb"
    "armchair__mid-century-chair__KatorLegaz.glb"
    "bar_table__bar_table__Scopia.glb"
    "bed__bed1__Scopia.glb"
    "bed__convertible-sofa-BZ-opened__Scopia.glb"
    "bench__bench__BlendSwap-CC-0.glb"
    "bench__bench__KatorLegaz.glb"
    "bookcase__bookcase__BlendSwap-CC-0.glb"
    "bookcase__full-bookcase__KatorLegaz.glb"
    "bookcase__kids_shelves__Scopia.glb"
    "bookcase__shelves__BlendSwap-CC-0.glb"
    "bookcase__verticalShelves__BlendSwap-CC-0.glb"
    "bowl__bowl__Scopia.glb"
    "bread__bread__BlendSwap-CC-0.glb"
    "chair__cafe_set_mota_chair__BlendSwap-CC-BY.glb"
    "chair__chair2__BlendSwap-CC-0.glb"
    "chair__chair3__BlendSwap-CC-BY.glb"
    "chair__chair3__Scopia.glb"
    "chair__chair4__Scopia.glb"
    "chair__chair__Scopia.glb"
    "chair__children_chair__Scopia.glb"
    "chair__dining-chair__KatorLegaz.glb"
    "chair__kitchenChair__BlendSwap-CC-BY.glb"
    "chair__osakaChair__BlendSwap-CC-0.glb"
    "chair__plaidChair__BlendSwap-CC-BY.glb"
    "chair__sillaBlanca__BlendSwap-CC-0.glb"
    "chair__tubular_chair__Scopia.glb"
    "chair__white_kitchen_chair__Scopia.glb"
    "coffee_table__coffee-table2__Scopia.glb"
    "coffee_table__coffeeTable__BlendSwap-CC-BY.glb"
    "coffee_table__living_room_table__Scopia.glb"
    "coffee_table__saloon_table__Scopia.glb"
    "coffee_table__table_wood_and_iron__Scopia.glb"
    "couch__burlap_sofa__Scopia.glb"
    "couch__clear_sofa__Scopia.glb"
    "couch__convertible-sofa-BZ-closed__Scopia.glb"
    "couch__cornerSofa__BlendSwap-CC-BY.glb"
    "couch__couch2__BlendSwap-CC-0.glb"
    "couch__day_bed_frame__Scopia.glb"
    "couch__futon-couch__KatorLegaz.glb"
    "couch__mid-century-bench-sofa__KatorLegaz.glb"
    "couch__mid-century-sofa__KatorLegaz.glb"
    "couch__simple_sofa__Scopia.glb"
    "couch__sofa2__BlendSwap-CC-0.glb"
    "couch__sofa__BlendSwap-CC-0.glb"
    "couch__sofa_white_beige__Scopia.glb"
    "desk_lamp__desklamp__BlendSwap-CC-0.glb"
    "dining_table__black_table__Scopia.glb"
    "dining_table__oakTable__BlendSwap-CC-0.glb"
    "dining_table__round-table__Scopia.glb"
    "dining_table__table-on-trestles__Scopia.glb"
    "dining_table__table-with-leaning-feet__Scopia.glb"
    "dining_table__table4__Scopia.glb"
    "dining_table__table__BlendSwap-CC-0.glb"
    "dining_table__table__BlendSwap-CC-BY.glb"
    "dining_table__white_kitchen_table__Scopia.glb"
    "drawers__dresserWithDrawers__BlendSwap-CC-BY.glb"
    "drawers__filing-cabinet__KatorLegaz.glb"
    "dressing_table__dressing-table__Scopia.glb"
    "folded_clothes__folded_clothes__Scopia.glb"
    "fridge__fridge__KatorLegaz.glb"
    "fridge__largeFridge__BlendSwap-CC-0.glb"
    "glass__12-oz-glass__KatorLegaz.glb"
    "kitchen_counter__drawersCabinet__BlendSwap-CC-0.glb"
    "kitchen_counter__lowerCabinet__BlendSwap-CC-0.glb"
    "kitchen_counter__sinkCabinet__BlendSwap-CC-0.glb"
    "kitchen_island__kitchenIsland__BlendSwap-CC-BY.glb"
    "mug__coffee-mug__KatorLegaz.glb"
    "newspaper__newspaper__KatorLegaz.glb"
    "nightstand__bedsideTable2__BlendSwap-CC-0.glb"
    "nightstand__bedsideTable__BlendSwap-CC-BY.glb"
    "office_chair__armchair__BlendSwap-CC-0.glb"
    "office_chair__office_chair__Scopia.glb"
    "office_desk__kids_wooden_desk__Scopia.glb"
    "office_desk__officeTable__BlendSwap-CC-BY.glb"
    "office_desk__simpleDesk__BlendSwap-CC-BY.glb"
    "office_desk__wooden_office_alder_table__Scopia.glb"
    "office_desk__wooden_office_pear_table_rect__Scopia.glb"
    "plant__maceta__Scopia.glb"
    "plate__bread-plate__KatorLegaz.glb"
    "potted_plant__littlePlant__BlendSwap-CC-0.glb"
    "remote_control__tv-remote-control__Scopia.glb"
    "shoes__sneakers__Scopia.glb"
    "stool__bar-stool__KatorLegaz.glb"
    "stool__bar_chair__Scopia.glb"
    "stool__green_stool__BlendSwap-CC-BY.glb"
    "stool__kitchen_stool__Scopia.glb"
    "stool__silla2__BlendSwap-CC-0.glb"
    "stool__stool2__BlendSwap-CC-0.glb"
    "table__children_table__Scopia.glb"
    "tablet__tablet__Scopia.glb"
    "toy__doll-house__Scopia.glb"
    "tv__wall-flat-tv__Scopia.glb"
    "tv_stand__tvStand__BlendSwap-CC-BY.glb"
    "vase__jar__Scopia.glb"
    "vase__vase1__Scopia.glb"
    "vase__vase3__Scopia.glb"
    "wardrobe__wardrobe1__Scopia.glb"
    "wardrobe__wardrobe2__BlendSwap-CC-BY.glb"
    "wardrobe__wardrobe__BlendSwap-CC-BY.glb"
    "wine_bottle__wine_bottle__Scopia.glb"
};

/// File names of all bundled furniture models, in alphabetical order.
pub fn furniture_names() -> impl Iterator<Item = &'static str> {
    FURNITURE.names()
}

/// The bundled furniture model of this file name; `None` if there is no such file.
///
/// # Errors
/// Never for an untouched program: what the reader says of a damaged file.
pub fn furniture_model(name: &str) -> Option<Result<Model, AssetError>> {
    FURNITURE.model(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bundled_model_reads_and_stands_on_its_origin() {
        for name in furniture_names() {
            let model = furniture_model(name).expect("listed").expect(name);
            let bounds = model.bounds();
            assert!(bounds.min.y.abs() < 0.005, "{name} stands at {}", bounds.min.y);
            assert!(bounds.center().with_y(0.0).length() < 0.01, "{name} is off its middle");
        }
        assert!(furniture_model("no such file").is_none());
    }
}
