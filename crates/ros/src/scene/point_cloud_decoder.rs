//! Decoder of `sensor_msgs/PointCloud2` of any layout.

use clearance_scene::{ByteOrder, CloudPoints, Column, Columns, NumberKind};
use ros2_interfaces_jazzy_serde::sensor_msgs::msg::{PointCloud2, PointField};

/// Points of a cloud, relative to an origin in its own frame. Several points at the origin are dropped like NaN. A single one is kept, since
/// in a map it may be a cell.
///
/// # Errors
/// Name of the invalid field.
pub fn decode(cloud: &PointCloud2) -> Result<CloudPoints, String> {
    let (width, height) = (size(cloud.width), size(cloud.height));
    let (point_step, row_step) = (size(cloud.point_step), size(cloud.row_step));
    // some drivers mark missing returns by large numbers as well
    let mut points = CloudPoints::of_sensor();
    let mut xyz = [0, 1, 2].map(|_| None);
    for (column, name) in xyz.iter_mut().zip(["x", "y", "z"]) {
        *column = Some(coordinate(cloud, name, point_step)?);
    }
    if width == 0 || height == 0 {
        return Ok(points);
    }
    let row = width.checked_mul(point_step).filter(|_| point_step > 0);
    let row = row.ok_or_else(|| format!("point_step is {point_step}: points have no size"))?;
    if row_step < row {
        return Err(format!("row_step is {row_step}, but {width} points of {point_step} bytes take {row}"));
    }
    // the last row needs no padding
    let needed = row_step.checked_mul(height - 1).and_then(|before| before.checked_add(row));
    if needed.is_none_or(|needed| needed > cloud.data.len()) {
        let bytes = cloud.data.len();
        return Err(format!("data has {bytes} bytes, too few for {height} rows of {width} points"));
    }
    let order = if cloud.is_bigendian { ByteOrder::Big } else { ByteOrder::Little };
    for row in 0..height {
        let place = |column: Option<Column>| {
            let Column { first, stride, kind } = column.expect("all three were found");
            Column { first: first + row * row_step, stride, kind }
        };
        let columns = Columns { xyz: xyz.map(place), order };
        points.read(&cloud.data, &columns, width).map_err(|error| format!("data: {error}"))?;
    }
    points.take_origin_points();
    Ok(points)
}

fn coordinate(cloud: &PointCloud2, name: &str, point_step: usize) -> Result<Column, String> {
    let mut named = cloud.fields.iter().filter(|field| field.name == name);
    let field = named.next().ok_or_else(|| format!("fields: there is no field '{name}'"))?;
    if named.next().is_some() {
        return Err(format!("fields: field '{name}' is there twice"));
    }
    let kind = match field.datatype {
        PointField::FLOAT32 => NumberKind::F32,
        PointField::FLOAT64 => NumberKind::F64,
        other => {
            return Err(format!(
                "fields: field '{name}' has datatype {other}, but coordinates are FLOAT32 (7) or FLOAT64 (8)"
            ));
        }
    };
    let first = size(field.offset);
    if first.checked_add(kind.size()).is_none_or(|end| end > point_step) {
        return Err(format!(
            "fields: field '{name}' at offset {first} reaches out of point_step {point_step}"
        ));
    }
    Ok(Column { first, stride: point_step, kind })
}

fn size(number: u32) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}
