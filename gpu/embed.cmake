# cmake -DIN=FILE -DOUT=FILE.c -DNAME=symbol -P embed.cmake: FILE as `const unsigned char symbol[]`, ended by a zero, and
# `const unsigned long symbol_bytes` without it.
file(READ ${IN} bytes HEX)
file(SIZE ${IN} size)
string(REGEX REPLACE "(................................................................)" "\\1\n" bytes "${bytes}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE ${OUT} "extern const unsigned char ${NAME}[];\nextern const unsigned long ${NAME}_bytes;\n"
	"const unsigned char ${NAME}[] __attribute__((aligned(64))) = {\n${bytes}0};\nconst unsigned long ${NAME}_bytes = ${size};\n")
