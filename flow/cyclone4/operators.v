// What alumacc would not do as well for this device.

// All comparisons as "less than", which is the borrow of one subtraction: of the others it would also compare
// for equality.

(* techmap_celltype = "$gt $ge $le" *)
module cyclone4_comparison (A, B, Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;
  parameter _TECHMAP_CELLTYPE_ = "";
  input [A_WIDTH-1:0] A;
  input [B_WIDTH-1:0] B;
  output [Y_WIDTH-1:0] Y;

  localparam SWAPPED = _TECHMAP_CELLTYPE_ != "$ge";
  localparam INVERTED = _TECHMAP_CELLTYPE_ != "$gt";
  wire less;
  generate
    if (SWAPPED)
      \$lt #(.A_SIGNED(B_SIGNED), .B_SIGNED(A_SIGNED), .A_WIDTH(B_WIDTH), .B_WIDTH(A_WIDTH), .Y_WIDTH(1))
        below (.A(B), .B(A), .Y(less));
    else
      \$lt #(.A_SIGNED(A_SIGNED), .B_SIGNED(B_SIGNED), .A_WIDTH(A_WIDTH), .B_WIDTH(B_WIDTH), .Y_WIDTH(1))
        below (.A(A), .B(B), .Y(less));
  endgenerate
  assign Y = less ^ INVERTED;
endmodule

// One carry chain for each addition: sums of three it would first reduce to two, by two tables for each bit.

(* techmap_celltype = "$add $sub" *)
module cyclone4_addition (A, B, Y);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 1;
  parameter B_WIDTH = 1;
  parameter Y_WIDTH = 1;
  parameter _TECHMAP_CELLTYPE_ = "";
  input [A_WIDTH-1:0] A;
  input [B_WIDTH-1:0] B;
  output [Y_WIDTH-1:0] Y;

  localparam [0:0] SUBTRACT = _TECHMAP_CELLTYPE_ == "$sub";
  wire [Y_WIDTH-1:0] x, carries;
  // an operand is only extended by its sign where both are signed
  localparam SIGNED = A_SIGNED && B_SIGNED;
  \$alu #(.A_SIGNED(SIGNED), .B_SIGNED(SIGNED), .A_WIDTH(A_WIDTH), .B_WIDTH(B_WIDTH), .Y_WIDTH(Y_WIDTH))
    sum (.A(A), .B(B), .CI(SUBTRACT), .BI(SUBTRACT), .X(x), .Y(Y), .CO(carries));
endmodule
